// How long a command to move holds. What moves must not go on when whoever moved it has died: so a
// command holds for three periods of its sender, which are learnt from its commands, unless a time
// is set.
#pragma once

#include <array>
#include <cstddef>

#include "tims/time.h"

namespace rack::device {

using tims::Duration;
using tims::Time;

class MoveDeadline {
 public:
  // 0: three periods of the sender.
  explicit MoveDeadline(Duration fixed = {}) : fixed_(fixed) {}

  void on_move(Time now);
  // It stands, or does something else.
  void end() { moved_ = tims::kNever; }
  // And somebody else commands from now on.
  void forget();

  [[nodiscard]] bool holds() const { return moved_ != tims::kNever; }
  [[nodiscard]] Duration length() const;
  // When the last command is too old; kNever: none holds.
  [[nodiscard]] Time due() const { return holds() ? moved_ + length() : tims::kNever; }

 private:
  static constexpr std::size_t kGaps = 5;

  [[nodiscard]] Duration period() const;

  Duration fixed_;
  std::array<Duration, kGaps> gaps_{};
  std::size_t count_ = 0;
  Time last_{};
  Time moved_ = tims::kNever;
};

}  // namespace rack::device
