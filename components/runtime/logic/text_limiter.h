// Keeps a component that has much to say from flooding those who read it: a burst, then a steady
// rate; what is too much is counted and told once there is room again. Pure.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "tims/time.h"

namespace rack {

class TextLimiter {
 public:
  static constexpr std::uint32_t kBurst = 50;
  static constexpr tims::Duration kEach = std::chrono::milliseconds(100);  // from then on

  explicit TextLimiter(std::uint32_t burst = kBurst, tims::Duration each = kEach)
      : burst_(burst), each_(each) {}

  // Whether a text may go now.
  bool take(tims::Time now) {
    // The time up to which texts are paid for runs ahead of `now` by at most a burst.
    paid_ = std::max(paid_, now);
    if (paid_ + each_ > now + burst_ * each_) {
      ++suppressed_;
      return false;
    }
    paid_ += each_;
    return true;
  }
  // How many were kept back since the last time this was asked.
  std::uint32_t take_suppressed() { return std::exchange(suppressed_, 0); }

  // Nothing owed, nothing to tell: as new.
  [[nodiscard]] bool is_idle(tims::Time now) const { return paid_ <= now && suppressed_ == 0; }

 private:
  std::uint32_t burst_;
  tims::Duration each_;
  tims::Time paid_{};
  std::uint32_t suppressed_ = 0;
};

}  // namespace rack
