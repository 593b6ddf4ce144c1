// A rate in bytes a second, with what may go at once after a pause.
#pragma once

#include <algorithm>
#include <cstdint>

#include "tims/time.h"

namespace tims::link {

class TokenBucket {
 public:
  // `rate` 0: no limit.
  void set(std::uint64_t rate, std::uint64_t depth) {
    rate_ = rate;
    depth_ = static_cast<double>(depth);
    tokens_ = std::min(tokens_, depth_);
  }

  [[nodiscard]] bool limits() const { return rate_ != 0; }
  // Something may go when the bucket is not in debt; what goes may be larger than what is in it.
  [[nodiscard]] bool ready(Time now) {
    fill(now);
    return !limits() || tokens_ > 0;
  }
  void take(std::uint64_t bytes) {
    if (limits()) tokens_ -= static_cast<double>(bytes);
  }
  // When it is ready again, at or after `now`.
  [[nodiscard]] Time ready_at(Time now) {
    if (ready(now)) return now;
    const double seconds = (1.0 - tokens_) / static_cast<double>(rate_);
    return now + std::chrono::duration_cast<Duration>(std::chrono::duration<double>(seconds)) +
           Duration(1);
  }
  // How much may go now, at most; at least 1 when ready.
  [[nodiscard]] double tokens() const { return tokens_; }

 private:
  void fill(Time now) {
    if (now > filled_) {
      const double seconds = std::chrono::duration<double>(now - filled_).count();
      tokens_ = std::min(depth_, tokens_ + seconds * static_cast<double>(rate_));
      filled_ = now;
    }
  }

  std::uint64_t rate_ = 0;
  double depth_ = 0;
  double tokens_ = 0;
  Time filled_{};
};

}  // namespace tims::link
