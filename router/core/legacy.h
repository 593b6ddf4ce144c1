// What original programs expect of their router: its commands and its watchdog (specification,
// sections 3.2 and 3.4).
#pragma once

#include <cstddef>
#include <cstdint>

#include "router/core/registrations.h"
#include "router/core/types.h"
#include "tims/address.h"
#include "tims/time.h"

namespace tims::core {

// A decoded command to the router: a message with dest = src = 0. router.cpp executes it.
struct LegacyCommand {
  enum class Verb : std::uint8_t {
    kLogin,     // nothing to do
    kRegister,  // mailbox, wants_reply
    kDelete,    // mailbox, wants_reply
    kPurge,     // all mailboxes of this connection
    kAlive,     // the answer to a lifesign
    kEnableWatchdog,
    kDisableWatchdog,
    kAdmin,      // extension: a question in JSON
    kMalformed,  // too short; never answered
    kUnknown,    // never answered; also a lifesign sent by a client
  };
  Verb verb = Verb::kUnknown;
  bool wants_reply = false;
  Address mailbox{};
  bool keeps_newest = false;  // kRegister: router_command::kKeepNewest
};

constexpr bool is_for_router(const Header& h) { return (h.dest.raw() | h.src.raw()) == 0; }

LegacyCommand parse_command(const Message& message);

// The original's watchdog: one common period for all clients. In each period every watched client
// is sent a lifesign; a client that has not answered the previous one is disconnected. While no
// client is watched there is no period and no timer.
class Lifesigns {
 public:
  explicit Lifesigns(Duration interval) : interval_(interval) {}

  void set_interval(Time now, Duration interval);

  void watch(Time now, Client& client);
  void unwatch(Client& client);

  [[nodiscard]] Time next_beat() const { return watched_ == 0 ? kNever : next_; }

  // Checks whether the period is over. If so, call turn() for every watched client afterwards.
  enum class Beat : std::uint8_t {
    kNotYet,
    kAsk,   // ask all; disconnect those that have not answered
    kLate,  // ask all: the router itself was delayed, and answers may wait in its sockets
  };
  Beat beat(Time now);

 private:
  Duration interval_;
  Time next_{};
  std::size_t watched_ = 0;
};

}  // namespace tims::core
