// Validity of motion commands. A device must stop when the sender of its commands crashes. A
// command is therefore valid for three periods of its sender, which are estimated from its
// commands, unless a fixed time is set.
#pragma once

#include <array>
#include <cstddef>

#include "tims/time.h"

namespace rack::device {

using tims::Duration;
using tims::Time;

class MoveDeadline {
 public:
  // fixed: validity; 0: three periods of the sender.
  explicit MoveDeadline(Duration fixed = {}) : fixed_(fixed) {}

  void on_move(Time now);
  // The motion has ended or was replaced: no command is valid.
  void end() { moved_ = tims::kNever; }
  // The same, and a new sender follows: discards the estimated period.
  void forget();

  [[nodiscard]] bool holds() const { return moved_ != tims::kNever; }
  [[nodiscard]] Duration length() const;
  // When the last command expires; kNever: no command is valid.
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
