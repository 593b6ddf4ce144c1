#include "router/link/congestion.h"

#include <algorithm>
#include <utility>

namespace tims::link {
namespace {

constexpr Duration kSlowDownEvery = std::chrono::seconds(4);

}  // namespace

void Congestion::on_feedback(Time now, const Feedback& feedback) {
  if (feedback.rtt > Duration::zero()) add_sample(now, feedback.rtt);
  round_acked_ += feedback.bytes_acked;
  round_packets_ += feedback.packets_acked + feedback.packets_lost;
  round_lost_ += feedback.packets_lost;
  if (feedback.in_flight + 2 * datagram_ > window_) round_limited_ = true;
  if (feedback.packets_acked > 0 && feedback.newest_acked >= round_end_) end_round(now, feedback);
}

void Congestion::add_sample(Time now, Duration rtt) {
  if (now >= base_since_ + kBaseSpan) {
    base_ = {Duration::max(), base_[0]};
    base_since_ = now;
  }
  base_[0] = std::min(base_[0], rtt);
  round_rtt_ = std::min(round_rtt_, rtt);
}

Duration Congestion::base_rtt() const {
  const Duration base = std::min(base_[0], base_[1]);
  return base == Duration::max() ? Duration::zero() : base;
}

std::uint64_t Congestion::at_least_min(std::uint64_t window) const {
  return std::clamp<std::uint64_t>(window, kMin * datagram_, kWindowMax);
}

void Congestion::end_round(Time now, const Feedback& feedback) {
  const bool measured = round_rtt_ != Duration::max();
  if (measured) queue_delay_ = round_rtt_ - std::min(round_rtt_, base_rtt());
  if (window_after_ != 0) {
    window_ = std::exchange(window_after_, 0);
  } else {
    if (measured) adapt_to_delay();
    adapt_to_loss();
    if (!slow_start_ && round_limited_ && now >= next_slow_down_) {
      // Out of the queue for a round, to see the path without it.
      next_slow_down_ = now + kSlowDownEvery;
      window_after_ = window_;
      const double part = queue_delay_ > Duration::zero()
                              ? static_cast<double>(base_rtt().count()) /
                                    static_cast<double>((base_rtt() + queue_delay_).count())
                              : 1.0;
      window_ =
          at_least_min(static_cast<std::uint64_t>(static_cast<double>(window_) * part * 0.75));
    }
  }
  begin_round(feedback);
}

void Congestion::adapt_to_delay() {
  const auto base = static_cast<double>(base_rtt().count());
  const auto target = static_cast<double>(kTarget.count());
  const auto queue = static_cast<double>(queue_delay_.count());
  if (queue > target) {
    slow_start_ = false;
    const double keep = std::max(0.5, (base + target) / (base + queue));
    window_ = at_least_min(static_cast<std::uint64_t>(static_cast<double>(window_) * keep));
    return;
  }
  if (!round_limited_) return;
  if (slow_start_ && queue > target / 2) slow_start_ = false;
  if (slow_start_) {
    window_ = at_least_min(2 * window_);
    return;
  }
  const double room = (target - queue) / target;
  const double step = std::max(static_cast<double>(datagram_), static_cast<double>(window_) / 32);
  window_ = at_least_min(window_ + static_cast<std::uint64_t>(step * room));
}

void Congestion::adapt_to_loss() {
  const bool lossy = round_packets_ >= 8 && round_lost_ * 8 > round_packets_;
  if (lossy && lossy_before_) {
    slow_start_ = false;
    window_ = at_least_min(std::min(window_, round_acked_));
  }
  lossy_before_ = lossy;
}

void Congestion::begin_round(const Feedback& feedback) {
  round_end_ = feedback.next_packet;
  round_rtt_ = Duration::max();
  round_acked_ = 0;
  round_packets_ = 0;
  round_lost_ = 0;
  round_limited_ = false;
}

void Congestion::on_silence() {
  window_ = kMin * datagram_;
  window_after_ = 0;
  slow_start_ = true;
  base_ = {Duration::max(), Duration::max()};
}

std::uint64_t Congestion::pacing_rate(Duration smoothed_rtt) const {
  const double seconds = std::max(1e-6, std::chrono::duration<double>(smoothed_rtt).count());
  const double gain = slow_start_ ? 2.0 : 1.25;
  return static_cast<std::uint64_t>(gain * static_cast<double>(window_) / seconds);
}

}  // namespace tims::link
