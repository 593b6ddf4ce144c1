// What a machine is told, until it begins to do it: in order, one never overtakes another.
// Allocates nothing.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include "tims/time.h"

namespace rack::device {

template <typename Wish>
class Delay {
 public:
  struct Due {
    tims::Time at{};
    Wish wish{};
  };

  // When too many are under way, it takes the last one's place.
  void tell(const Wish& wish, tims::Time due) {
    if (count_ == kUnderWayMax) --count_;
    if (count_ > 0) due = std::max(due, newest()->at);
    all_[(first_ + count_) % kUnderWayMax] = {due, wish};
    ++count_;
  }
  // The next that is due by then.
  std::optional<Due> take(tims::Time now) {
    if (count_ == 0 || all_[first_].at > now) return {};
    const Due due = all_[first_];
    first_ = (first_ + 1) % kUnderWayMax;
    --count_;
    return due;
  }
  // Null if nothing is under way.
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
