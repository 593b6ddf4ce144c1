// Small estimators: round-trip time, the other host's clock.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "tims/time.h"

namespace tims::link {

// Round-trip time, smoothed as in RFC 6298 and RFC 9002, section 5; and the smallest recent
// value.
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
  [[nodiscard]] Duration variation() const { return known() ? variation_ : kInitial / 2; }

  // A packet sent this long before an acknowledged one is lost (RFC 9002, 6.1.2).
  [[nodiscard]] Duration loss_delay() const {
    return std::max(std::max(smoothed(), latest_) * 9 / 8, kGranularity);
  }
  // After this time without an acknowledgement, a probe is sent to elicit one (RFC 9002, 6.2.1).
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

// Offset of the other host's clock from ours, from the four timestamps of keep-alives (RFC 5905,
// section 8): of the most recent samples, the one with the shortest round trip is used.
class ClockOffset {
 public:
  // Nanoseconds, each on the clock of its host: our send time, their receive time, their send
  // time, our receive time.
  void add(std::int64_t sent, std::int64_t their_received, std::int64_t their_sent,
           std::int64_t received) {
    Sample& sample = samples_[count_++ % samples_.size()];
    sample.round_trip = less(less(received, sent), less(their_sent, their_received));
    sample.offset = less(their_received, sent) / 2 + less(their_sent, received) / 2;
  }
  void reset() { count_ = 0; }

  struct Sample {
    std::int64_t offset = 0;      // theirs minus ours
    std::int64_t round_trip = 0;  // the error of the offset is at most half of it
  };
  [[nodiscard]] std::optional<Sample> best() const {
    if (count_ == 0) return std::nullopt;
    Sample best = samples_[0];
    for (std::size_t i = 1; i < std::min<std::size_t>(count_, samples_.size()); ++i) {
      if (samples_[i].round_trip < best.round_trip) best = samples_[i];
    }
    return best;
  }

 private:
  // Saturating: values received from the other side are arbitrary.
  static std::int64_t less(std::int64_t a, std::int64_t b) {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
  }

  std::array<Sample, 8> samples_{};
  std::size_t count_ = 0;
};

}  // namespace tims::link
