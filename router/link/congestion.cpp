#include "router/link/congestion.h"

#include <algorithm>
#include <utility>

namespace tims::link {
namespace {

// Interval between two drains of two rounds each: in round trips, with a minimum and a maximum.
constexpr int kLeaveEvery = 30;
constexpr Duration kLeaveMost = std::chrono::seconds(4);
constexpr Duration kLeaveLeast = std::chrono::milliseconds(100);

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
  const Duration last = last_rtt_ == Duration::zero() ? rtt : last_rtt_;
  jitter_ += (std::max(rtt, last) - std::min(rtt, last) - jitter_) / 16;
  last_rtt_ = rtt;
  round_rtt_ = std::min(round_rtt_, rtt);
  round_rtt_max_ = std::max(round_rtt_max_, rtt);
}

Duration Congestion::base_rtt() const {
  const Duration base = std::min(base_[0], base_[1]);
  return base == Duration::max() ? Duration::zero() : base;
}

std::uint64_t Congestion::at_least_min(std::uint64_t window) const {
  return std::clamp<std::uint64_t>(window, kMin * datagram_, kWindowMax);
}

Duration Congestion::target() const {
  // At least two datagrams, where sending them takes long.
  const double datagrams = 2.0 * static_cast<double>(datagram_) / static_cast<double>(window_);
  const auto path = static_cast<double>((base_rtt() + others_).count());
  return std::max(kTarget + 2 * jitter_, Duration(static_cast<std::int64_t>(datagrams * path)));
}

void Congestion::end_round(Time now, const Feedback& feedback) {
  const bool measured = round_rtt_ != Duration::max();
  const Duration path = base_rtt() + others_;
  if (measured) queue_delay_ = round_rtt_ - std::min(round_rtt_, path);
  if (rounds_away_ > 0) {
    if (--rounds_away_ == 0) come_back(now, measured ? round_rtt_ : path);
  } else {
    const bool grew = slow_start_;
    if (measured) adapt_to_delay();
    adapt_to_loss();
    const bool overshot = grew && !slow_start_;
    if (!slow_start_ && round_limited_ && (overshot || now >= next_leave_))
      leave_queue(now, overshot);
  }
  begin_round(feedback);
  round_since_ = now;
}

double Congestion::round_rate(Time now) const {
  const double seconds = std::chrono::duration<double>(now - round_since_).count();
  return static_cast<double>(round_acked_) / std::max(1e-6, seconds);
}

void Congestion::leave_queue(Time now, bool overshot) {
  // The amount delivered in this round is at most the capacity of the path.
  rate_before_ = round_rate(now);
  const auto window_of = [&](Duration time) {
    const double bytes = rate_before_ * std::chrono::duration<double>(time).count();
    return at_least_min(std::min(window_, static_cast<std::uint64_t>(bytes)));
  };
  const Duration path = base_rtt() + others_;
  rtt_before_ = round_rtt_ == Duration::max() ? path : round_rtt_;
  rounds_away_ = 2;
  window_after_ = overshot ? window_of(path + target()) : window_;
  window_ = window_of(path * 9 / 10);
}

void Congestion::come_back(Time now, Duration rtt) {
  next_leave_ = now + std::clamp(kLeaveEvery * rtt, kLeaveLeast, kLeaveMost);
  // Less was delivered because less was sent: the path was not full, so the delay was not our
  // queue.
  const double part = static_cast<double>(window_) / static_cast<double>(window_after_);
  const bool was_full = part > 0.7 || round_rate(now) > rate_before_ * (1 + part) / 2;
  const Duration left = (was_full ? rtt : std::max(rtt, rtt_before_)) - base_rtt();
  others_ = std::max({left, others_ / 2, Duration::zero()});
  window_ = std::exchange(window_after_, 0);
}

void Congestion::adapt_to_delay() {
  const auto path = static_cast<double>((base_rtt() + others_).count());
  const auto most = static_cast<double>(target().count());
  const auto queue = static_cast<double>(queue_delay_.count());
  if (queue > most) {
    slow_start_ = false;
    const double keep = std::max(0.5, (path + most) / (path + queue));
    window_ = at_least_min(static_cast<std::uint64_t>(static_cast<double>(window_) * keep));
    return;
  }
  if (!round_limited_) return;
  if (slow_start_ && queue > most / 2) slow_start_ = false;
  if (slow_start_) {
    window_ = at_least_min(2 * window_);
    return;
  }
  const double room = (most - queue) / most;
  const double step = std::max(static_cast<double>(datagram_), static_cast<double>(window_) / 16);
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
  round_rtt_max_ = {};
  round_acked_ = 0;
  round_packets_ = 0;
  round_lost_ = 0;
  round_limited_ = false;
}

void Congestion::on_silence() {
  window_ = kMin * datagram_;
  window_after_ = 0;
  rounds_away_ = 0;
  others_ = {};
  slow_start_ = true;
  base_ = {Duration::max(), Duration::max()};
}

std::uint64_t Congestion::rate(Duration smoothed_rtt) const {
  const double seconds = std::max(1e-6, std::chrono::duration<double>(smoothed_rtt).count());
  return static_cast<std::uint64_t>(static_cast<double>(window_) / seconds);
}

std::uint64_t Congestion::pacing_rate(Duration smoothed_rtt) const {
  const std::uint64_t rate = this->rate(smoothed_rtt);
  return slow_start_ ? 2 * rate : rate + rate / 4;
}

}  // namespace tims::link
