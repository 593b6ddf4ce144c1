// How much may go in a while: bytes on a link, answers, lines that people read. Each is a token
// bucket: it fills at the rate, holds no more than what may go at once after a pause, and what goes
// is taken out of it. Time is an argument.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "tims/time.h"

namespace tims::base {

class RateLimiter {
 public:
  RateLimiter() = default;  // no limit
  // `rate`: units a second, 0: no limit. `burst`: units that may go at once. It is full.
  RateLimiter(std::uint64_t rate, std::uint64_t burst)
      : rate_(rate), burst_(static_cast<double>(burst)), left_(burst_) {}

  // What was taken stays so.
  void set(std::uint64_t rate, std::uint64_t burst) {
    rate_ = rate;
    burst_ = static_cast<double>(burst);
    left_ = std::min(left_, burst_);
  }

  [[nodiscard]] bool limits() const { return rate_ != 0; }
  // Something may go when the bucket is not in debt; what goes may be larger than what is in it.
  [[nodiscard]] bool ready(Time now) {
    fill(now);
    return !limits() || left_ > 0;
  }
  void take(std::uint64_t units) {
    if (limits()) left_ -= static_cast<double>(units);
  }
  // Takes one unit, if a whole one is there.
  bool try_take(Time now) {
    constexpr double kRounding = 1e-6;
    fill(now);
    if (limits() && left_ < 1 - kRounding) return false;
    take(1);
    return true;
  }
  // When it is ready again, at or after `now`.
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

// Lines for people, from somebody who may have much to say: what is too much is counted, and told
// once there is room again.
class LineLimiter {
 public:
  LineLimiter(std::uint64_t lines_per_second, std::uint64_t burst)
      : limiter_(lines_per_second, burst) {}

  // Whether a line may go now.
  bool take(Time now) {
    const bool may_go = limiter_.try_take(now);
    held_back_ += may_go ? 0 : 1;
    return may_go;
  }
  // How many were held back since the last time this was asked.
  std::uint32_t take_held_back() { return std::exchange(held_back_, 0); }

  // As new: nothing was taken lately, nothing is to be told.
  [[nodiscard]] bool is_idle(Time now) const { return limiter_.is_full(now) && held_back_ == 0; }

 private:
  RateLimiter limiter_;
  std::uint32_t held_back_ = 0;
};

}  // namespace tims::base
