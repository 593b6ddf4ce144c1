// Keys for the routers of a measurement with sealed links.
#pragma once

#include <cstdint>
#include <string>

#include "security/keys/authority.h"

namespace tims::bench {

class FleetKeys {
 public:
  // Makes an authority in the folder, which may have the one of an earlier measurement.
  static Result<FleetKeys> make(std::string folder);

  // Makes the keys of a router; they are in folder_of() then.
  Result<void> add(security::MemberRole role, std::uint16_t system, std::uint16_t id) const;
  [[nodiscard]] std::string folder_of(security::MemberRole role, std::uint16_t system,
                                      std::uint16_t id) const;
  // The same of a fleet in this folder.
  static std::string folder_of(const std::string& folder, security::MemberRole role,
                               std::uint16_t system, std::uint16_t id);

 private:
  FleetKeys(std::string folder, security::Authority authority)
      : folder_(std::move(folder)), authority_(std::move(authority)) {}

  std::string folder_;
  security::Authority authority_;
};

}  // namespace tims::bench
