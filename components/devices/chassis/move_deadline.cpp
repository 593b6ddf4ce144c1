#include "components/devices/chassis/move_deadline.h"

#include <algorithm>

namespace rack::device {
namespace {

using namespace std::chrono_literals;

constexpr int kPeriods = 3;
constexpr Duration kUnknown = 100ms;
constexpr Duration kShortest = 50ms;  // minimum, tolerates a delay by the scheduler
constexpr Duration kLongest = 1s;     // after a longer gap the estimation starts again

}  // namespace

void MoveDeadline::on_move(Time now) {
  const Duration gap = now - last_;
  if (last_ != Time{} && gap <= kLongest)
    gaps_[count_++ % kGaps] = gap;
  else
    count_ = 0;
  last_ = moved_ = now;
}

void MoveDeadline::forget() {
  count_ = 0;
  last_ = {};
  end();
}

// The median of the last intervals, so that single very short or long intervals have no effect.
Duration MoveDeadline::period() const {
  constexpr std::size_t kEnough = 3;
  const std::size_t known = std::min(count_, kGaps);
  if (known < kEnough) return kUnknown;
  auto sorted = gaps_;
  std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(known));
  return sorted[known / 2];
}

Duration MoveDeadline::length() const {
  if (fixed_ > Duration(0)) return fixed_;
  return std::clamp<Duration>(kPeriods * period(), kShortest, kLongest);
}

}  // namespace rack::device
