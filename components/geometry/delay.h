// A delay line for commands: they take effect in order after a lag; none overtakes another. And the
// command that a motor with such a lag executes. Both allocate nothing.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <optional>

#include "tims/time.h"

namespace rack::device {

template <typename Command>
class Delay {
 public:
  struct Due {
    tims::Time at{};
    Command command{};
  };

  // When the buffer is full, the new command replaces the last one.
  void push(const Command& command, tims::Time due) {
    if (count_ == kInFlightMax) --count_;
    if (count_ > 0) due = std::max(due, newest()->at);
    all_[(first_ + count_) % kInFlightMax] = {due, command};
    ++count_;
  }
  // The next command that is due at `now`.
  std::optional<Due> take(tims::Time now) {
    if (count_ == 0 || all_[first_].at > now) return {};
    const Due due = all_[first_];
    first_ = (first_ + 1) % kInFlightMax;
    --count_;
    return due;
  }
  // nullptr when no command is pending.
  [[nodiscard]] const Due* newest() const {
    return count_ == 0 ? nullptr : &all_[(first_ + count_ - 1) % kInFlightMax];
  }
  void forget() { count_ = 0; }

  static constexpr std::size_t kInFlightMax = 256;

 private:
  std::array<Due, kInFlightMax> all_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

template <typename Command>
class LaggingCommand {
 public:
  void set_lag(tims::Duration lag) { lag_ = lag; }
  void set(const Command& command) {
    if (lag_ == tims::Duration{})
      in_effect_ = command;
    else
      in_flight_.push(command, now_ + lag_);
  }
  [[nodiscard]] const Command& in_effect() const { return in_effect_; }
  [[nodiscard]] const Command& newest() const {
    return in_flight_.newest() ? in_flight_.newest()->command : in_effect_;
  }
  // Calls `move(seconds)` for each part of the time until `now` in which one command is in effect.
  template <typename Move>
  void step(tims::Time now, Move move) {
    // Arrivals have the time when they were on the line, which may be before the last step.
    if (now_ == tims::Time{}) now_ = now;
    if (now < now_) return;
    const auto go_on = [&](tims::Time until) {
      if (until <= now_) return;
      move(std::chrono::duration<double>(until - now_).count());
      now_ = until;
    };
    while (const auto due = in_flight_.take(now)) {
      go_on(due->at);
      in_effect_ = due->command;
    }
    go_on(now);
  }

 private:
  tims::Duration lag_{};
  Delay<Command> in_flight_;
  Command in_effect_{};
  tims::Time now_{};
};

}  // namespace rack::device
