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

// A command to the router: a message with dest = src = 0. What it means; router.cpp carries it out.
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

// The original's watchdog: one beat for all clients. With each beat
// every watched client is asked whether it lives; one that still owes the answer when the next
// beat comes is given up. While no client is watched there is no beat and no timer.
class Lifesigns {
 public:
  explicit Lifesigns(Duration interval) : interval_(interval) {}

  void set_interval(Time now, Duration interval);

  void watch(Time now, Client& client);
  void unwatch(Client& client);

  [[nodiscard]] Time next_beat() const { return watched_ == 0 ? kNever : next_; }

  // Is it time? Then every watched client wants its turn() after this.
  enum class Beat : std::uint8_t {
    kNotYet,
    kAsk,   // ask all, give up those that owe an answer
    kLate,  // ask all: the router itself was away, and answers may wait in its sockets
  };
  Beat beat(Time now);

 private:
  Duration interval_;
  Time next_{};
  std::size_t watched_ = 0;
};

}  // namespace tims::core
