// Commands of the original protocol to the router: messages with dest = src = 0 (specification,
// section 3.2). What they mean; router.cpp carries them out.
#pragma once

#include <cstdint>

#include "router/core/message.h"
#include "tims/address.h"

namespace tims::core {

struct LegacyCommand {
  enum class Verb : std::uint8_t {
    kLogin,     // nothing to do
    kRegister,  // mailbox, wants_reply
    kDelete,    // mailbox, wants_reply
    kPurge,     // all mailboxes of this connection
    kAlive,     // the answer to a lifesign
    kEnableWatchdog,
    kDisableWatchdog,
    kAdmin,      // ours: a question in JSON
    kMalformed,  // too short; never answered, whatever it was
    kUnknown,    // never answered; also a lifesign sent by a client
  };
  Verb verb = Verb::kUnknown;
  bool wants_reply = false;
  Address mailbox{};
};

constexpr bool is_for_router(const Header& h) { return (h.dest.raw() | h.src.raw()) == 0; }

LegacyCommand parse_command(const Message& message);

}  // namespace tims::core
