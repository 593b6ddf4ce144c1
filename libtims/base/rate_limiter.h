// Limits a rate: bytes on a link, answers, log lines. Each limiter is a token bucket: it fills at
// the rate, holds at most the burst, and every use takes tokens out of it. Time is an argument.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "tims/time.h"

namespace tims::base {

class RateLimiter {
 public:
  RateLimiter() = default;  // no limit
  // `rate`: units per second, 0: no limit. `burst`: units allowed at once. The bucket starts full.
  RateLimiter(std::uint64_t rate, std::uint64_t burst)
      : rate_(rate), burst_(static_cast<double>(burst)), left_(burst_) {}

  // Changes the limits; tokens already taken stay taken.
  void set(std::uint64_t rate, std::uint64_t burst) {
    rate_ = rate;
    burst_ = static_cast<double>(burst);
    left_ = std::min(left_, burst_);
  }

  [[nodiscard]] bool limits() const { return rate_ != 0; }
  // True when the bucket is not in debt. The next use may be larger than the number of tokens left.
  [[nodiscard]] bool ready(Time now) {
    fill(now);
    return !limits() || left_ > 0;
  }
  void take(std::uint64_t units) {
    if (limits()) left_ -= static_cast<double>(units);
  }
  // Takes one token if a whole one is available.
  bool try_take(Time now) {
    constexpr double kRounding = 1e-6;
    fill(now);
    if (limits() && left_ < 1 - kRounding) return false;
    take(1);
    return true;
  }
  // Earliest time, not before `now`, when the limiter is ready.
  [[nodiscard]] Time ready_at(Time now) {
    if (ready(now)) return now;
    const double seconds = (1.0 - left_) / static_cast<double>(rate_);
    return now + std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds)) +
           Duration(1);
  }
  [[nodiscard]] bool is_full(Time now) const { return !limits() || left_at(now) >= burst_; }

 private:
  [[nodiscard]] double left_at(Time now) const {
    if (now <= filled_) return left_;
    const double seconds = std::chrono::duration<double>(now - filled_).count();
    return std::min(burst_, left_ + seconds * static_cast<double>(rate_));
  }
  void fill(Time now) {
    left_ = left_at(now);
    filled_ = std::max(filled_, now);
  }

  std::uint64_t rate_ = 0;
  double burst_ = 0;
  double left_ = 0;
  Time filled_{};
};

// Limits log lines of one source: suppressed lines are counted, and the count is reported when
// lines are allowed again.
class LineLimiter {
 public:
  LineLimiter(std::uint64_t lines_per_second, std::uint64_t burst)
      : limiter_(lines_per_second, burst) {}

  // Whether a line may be written now.
  bool take(Time now) {
    const bool may_go = limiter_.try_take(now);
    held_back_ += may_go ? 0 : 1;
    return may_go;
  }
  // Number of lines suppressed since the last call.
  std::uint32_t take_held_back() { return std::exchange(held_back_, 0); }

  // True when the bucket is full and no suppressed lines are to be reported.
  [[nodiscard]] bool is_idle(Time now) const { return limiter_.is_full(now) && held_back_ == 0; }

 private:
  RateLimiter limiter_;
  std::uint32_t held_back_ = 0;
};

}  // namespace tims::base
