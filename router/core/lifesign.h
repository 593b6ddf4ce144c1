// The original's watchdog (specification, section 3.4): one beat for all clients. With each beat
// every watched client is asked whether it lives; one that still owes the answer when the next
// beat comes is given up. While no client is watched there is no beat and no timer.
#pragma once

#include <cstddef>

#include "router/core/clients.h"
#include "tims/time.h"

namespace tims::core {

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
