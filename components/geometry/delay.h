// A delay line for commands: they take effect in order after a lag; none overtakes another.
// Allocates nothing.
#pragma once

#include <algorithm>
#include <array>
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
  void tell(const Command& command, tims::Time due) {
    if (count_ == kUnderWayMax) --count_;
    if (count_ > 0) due = std::max(due, newest()->at);
    all_[(first_ + count_) % kUnderWayMax] = {due, command};
    ++count_;
  }
  // The next command that is due at `now`.
  std::optional<Due> take(tims::Time now) {
    if (count_ == 0 || all_[first_].at > now) return {};
    const Due due = all_[first_];
    first_ = (first_ + 1) % kUnderWayMax;
    --count_;
    return due;
  }
  // nullptr when no command is pending.
  [[nodiscard]] const Due* newest() const {
    return count_ == 0 ? nullptr : &all_[(first_ + count_ - 1) % kUnderWayMax];
  }
  void forget() { count_ = 0; }

  static constexpr std::size_t kUnderWayMax = 256;

 private:
  std::array<Due, kUnderWayMax> all_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

}  // namespace rack::device
