// Many changes close together are one: it is due once they have ended, and not too late when they
// do not end.
#pragma once

#include <algorithm>
#include <chrono>

#include "tims/time.h"

namespace tims::io {

class Debounce {
 public:
  static constexpr Duration kQuiet = std::chrono::milliseconds(50);    // after the last change
  static constexpr Duration kAtMost = std::chrono::milliseconds(300);  // after the first one

  void on_change(Time now) {
    if (due_ == kNever) first_ = now;
    due_ = std::min(now + kQuiet, first_ + kAtMost);
  }
  [[nodiscard]] Time due() const { return due_; }  // kNever: there was none
  void reset() { due_ = kNever; }

 private:
  Time first_{};
  Time due_ = kNever;
};

}  // namespace tims::io
