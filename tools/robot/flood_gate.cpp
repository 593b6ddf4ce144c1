#include "tools/robot/flood_gate.h"

#include <algorithm>
#include <utility>

namespace timsctl::robot {

std::uint64_t FloodGate::pass(tims::Time now, std::uint64_t lines) {
  if (cut_) measure(now);
  std::uint64_t passed = 0;
  while (!cut_ && passed < lines) {
    if (limiter_.take(now)) {
      ++passed;
    } else {
      cut_ = true;
      cut_at_ = second_ = now;
      in_second_ = 0;
    }
  }
  held_back_ += lines - passed;
  in_second_ += lines - passed;
  return passed;
}

// The gate opens after a second with few lines.
void FloodGate::measure(tims::Time now) {
  if (now - second_ < std::chrono::seconds(1)) return;
  const bool long_ago = now - second_ >= std::chrono::seconds(2);
  cut_ = !long_ago && in_second_ > kLinesPerSecond;
  second_ = now;
  in_second_ = 0;
}

std::optional<std::uint64_t> FloodGate::take_report(tims::Time now) {
  if (cut_) measure(now);
  if (now < report_at()) return std::nullopt;
  reported_ = now;
  return std::exchange(held_back_, 0);
}

tims::Time FloodGate::report_at() const {
  if (held_back_ == 0) return tims::kNever;
  return std::max(reported_ + kFloodReportEach, cut_at_ + std::chrono::seconds(1));
}

}  // namespace timsctl::robot
