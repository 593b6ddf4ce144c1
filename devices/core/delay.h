// What a machine is told, until it begins to do it. Allocates nothing.
#pragma once

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

  void set(tims::Duration lag) { lag_ = lag; }
  [[nodiscard]] bool is_none() const { return lag_ == tims::Duration{}; }

  // When too many are under way, it takes the last one's place.
  void tell(const Wish& wish, tims::Time now) {
    if (count_ == kUnderWayMax) --count_;
    all_[(first_ + count_) % kUnderWayMax] = {now + lag_, wish};
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

  static constexpr std::size_t kUnderWayMax = 64;

 private:
  tims::Duration lag_{};
  std::array<Due, kUnderWayMax> all_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

}  // namespace rack::device
