// What a client that had to prove who it is may do: look, drive or configure; and what each message
// needs. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "router/core/router.h"
#include "router/policy/subject.h"
#include "router/policy/types.h"
#include "security/crypto/certificate.h"
#include "security/keys/identity.h"
#include "tims/address.h"

namespace tims::io {

struct Person {
  std::string name{};
  security::Rights rights{};
  // That of the user for whom the token was made; none: a user of this host.
  std::optional<security::Certificate> certificate{};
  // Who it has proven to be, for rules of the policy; empty: the user `name`.
  policy::Subject proven{};
};

// What somebody with these rights may send: see README.md. `body` without the header.
struct SentMessage {
  std::int8_t type = 0;
  bool to_router = false;      // dest = src = 0, or a router's own address
  bool to_agent = false;       // the configuration agent beside a router
  bool to_other = false;       // another router or its agent, which may be of a newer version
  std::uint32_t class_id = 0;  // of its receiver
  std::string_view body{};

  static SentMessage of(const core::Message& message, const core::RouterSettings& settings);
};
enum class Right : std::uint8_t { kNone, kLook, kDrive, kConfigure };
std::string_view name(Right right);
Right needed_for(const SentMessage& sent, const AddressWidths& widths);
// What the policy is asked about a question to a router or to the agent beside it.
policy::Right asked_of(const SentMessage& question, const AddressWidths& widths);
bool has(const security::Rights& rights, Right right);
// The highest right only, as texts and cookies name it.
Right highest(const security::Rights& rights);
// A right includes the lower ones.
security::Rights rights_up_to(Right right);
std::optional<Right> right_of(std::string_view text);

// Whom a certificate of the fleet makes its owner at the router `own`: a user what its rights are;
// a top-level router may configure, a router of the same robot drive, any other one look.
Person person_of(const security::Identity& identity, const security::Certificate& certificate,
                 const security::Identity& own);

}  // namespace tims::io
