// Round-trip time, smoothed as in RFC 6298 and RFC 9002, section 5; and the smallest one seen
// lately.
#pragma once

#include <algorithm>

#include "tims/time.h"

namespace tims::link {

class RttEstimator {
 public:
  void add(Duration sample) {
    latest_ = sample;
    if (smoothed_ == Duration::zero()) {
      smoothed_ = sample;
      variation_ = sample / 2;
      return;
    }
    const Duration off = smoothed_ > sample ? smoothed_ - sample : sample - smoothed_;
    variation_ = (3 * variation_ + off) / 4;
    smoothed_ = (7 * smoothed_ + sample) / 8;
  }
  void reset() { *this = RttEstimator(); }

  [[nodiscard]] bool known() const { return smoothed_ != Duration::zero(); }
  [[nodiscard]] Duration smoothed() const { return known() ? smoothed_ : kInitial; }
  [[nodiscard]] Duration latest() const { return latest_; }
  [[nodiscard]] Duration variation() const { return known() ? variation_ : kInitial / 2; }

  // A packet that was sent this long before one that is acknowledged is lost (RFC 9002, 6.1.2).
  [[nodiscard]] Duration loss_delay() const {
    return std::max(std::max(smoothed(), latest_) * 9 / 8, kGranularity);
  }
  // Without any acknowledgement for so long, something is sent to get one (RFC 9002, 6.2.1).
  [[nodiscard]] Duration probe_timeout() const {
    return smoothed() + std::max(4 * variation(), kGranularity) + kAckDelayMax;
  }

  static constexpr Duration kAckDelayMax = std::chrono::milliseconds(2);

 private:
  static constexpr Duration kInitial = std::chrono::milliseconds(100);
  static constexpr Duration kGranularity = std::chrono::milliseconds(1);

  Duration smoothed_{};
  Duration variation_{};
  Duration latest_{};
};

}  // namespace tims::link
