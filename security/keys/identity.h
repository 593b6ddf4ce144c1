// Who a certificate belongs to: read from the URIs among its subject's names, nothing else.
//
//   tims://FLEET/ROLE/SYSTEM/ID   a router; ROLE: subsystem, system or top
//   tims://FLEET/name/NAME        its name; one, together with the first
//   tims://FLEET/user/NAME        a person or program
//   tims://FLEET/right/RIGHT      what a user may do: look, drive, configure
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tims/result.h"

namespace tims::security {

enum class MemberRole : std::uint8_t { kSubsystem, kSystem, kTop, kUser };
std::string_view name(MemberRole role);
std::optional<MemberRole> role_of(std::string_view text);

struct Rights {
  bool look = false;
  bool drive = false;
  bool configure = false;
  bool operator==(const Rights&) const = default;
};

struct Identity {
  std::string fleet;
  MemberRole role = MemberRole::kSystem;
  std::uint16_t system = 0;  // of a router
  std::uint16_t id = 0;      // likewise
  std::string name;          // of the router or user
  Rights rights;             // of a user

  // The names for a certificate. Inverse of parse().
  [[nodiscard]] std::vector<std::string> uris() const;
  // "system 3, id 1 (robot3)", "user anna": for people.
  [[nodiscard]] std::string to_string() const;
  bool operator==(const Identity&) const = default;

  // Exactly one identity, each other URI once at most. Numbers have no sign and no leading zeros.
  // kMalformed: the detail names the URI and what is wrong.
  static Result<Identity> parse(const std::vector<std::string>& uris);
};

// Letters, digits, and "-", "_", "." between them; 1 to 63 characters. So are names of fleets,
// routers and users in certificates; they are compared exactly, also in case.
bool is_name(std::string_view text);

// "robot3" for system 3, "robot3-2" for the subsystem 3/2, "base" for a top router: what a member
// is called if nobody says otherwise.
std::string usual_name(MemberRole role, std::uint16_t system, std::uint16_t id);

}  // namespace tims::security
