// Session, the part that takes what comes.
#include <algorithm>

#include "router/link/session.h"

namespace tims::link {

namespace {

using namespace std::chrono_literals;

// Of a lane that the other side has no memory for.
constexpr Duration kPauseMin = 20ms;
constexpr Duration kPauseMax = 500ms;

}  // namespace

Session::Verdict Session::on_data(Time now, const Data& data) {
  const std::uint64_t number = window_.expand(data.header.packet);
  const bool newest = number >= window_.next();
  const bool in_order = number == window_.next();
  if (newest) newest_at_ = now;
  bool eliciting = false;
  bool keep = true;
  const Verdict verdict = on_frames(now, data, eliciting, keep);
  if (verdict == Verdict::kBroken) return verdict;
  if (!keep) {
    ++counters_.packets_refused;
    if (not_ready_ != 0) ack_now_ = true;
    return Verdict::kTaken;
  }
  window_.add(number);
  ++counters_.packets_in;
  counters_.bytes_in += kDataHeaderSize + data.frames.size();
  if (!eliciting) return verdict;
  ++unacked_;
  // At once when something is missing, so that the other side learns it soon; else for every second
  // one, or after a moment.
  if (!in_order || unacked_ >= 2) ack_now_ = true;
  ack_at_ = std::min(ack_at_, now + RttEstimator::kAckDelayMax);
  return verdict;
}

Session::Verdict Session::on_frames(Time now, const Data& data, bool& eliciting, bool& keep) {
  FrameReader reader(data.frames);
  bool broken = false;
  while (!broken) {
    const auto frame = reader.next();
    if (!frame) break;
    const auto lane_verdict = [&](std::size_t lane, LaneReceiver::Verdict v) {
      eliciting = true;
      if (v == LaneReceiver::Verdict::kRefused) {
        keep = false;
        if (receivers_[lane].has_refused(now)) not_ready_ |= static_cast<std::uint16_t>(1U << lane);
      }
      if (v == LaneReceiver::Verdict::kBroken) broken = true;
    };
    if (const auto* stream = std::get_if<StreamFrame>(&*frame)) {
      lane_verdict(stream->lane,
                   receivers_[stream->lane].on_bytes(now, stream->offset, stream->bytes,
                                                     stream->lane == kControlLane, arrivals_));
    } else if (const auto* sample = std::get_if<SampleFrame>(&*frame)) {
      eliciting = true;
      broken = !sample_receiver_.on_frame(now, *sample, arrivals_);
    } else if (const auto* ack = std::get_if<Ack>(&*frame)) {
      broken = !on_ack(now, *ack);
    } else if (const auto* skip = std::get_if<SkipFrame>(&*frame)) {
      lane_verdict(skip->lane, receivers_[skip->lane].on_skip(
                                   now, skip->to, skip->lane == kControlLane, arrivals_));
    } else if (const auto* keep_alive = std::get_if<KeepAlive>(&*frame)) {
      arrivals_.on_frame(now, *keep_alive);
    } else if (const auto* challenge = std::get_if<ChallengeFrame>(&*frame)) {
      ++questions_in_;
      arrivals_.on_frame(now, *challenge);
    } else if (const auto* response = std::get_if<ResponseFrame>(&*frame)) {
      ++questions_in_;
      arrivals_.on_frame(now, *response);
    } else if (const auto* close = std::get_if<CloseFrame>(&*frame)) {
      arrivals_.on_frame(now, *close);
    } else if (const auto* not_ready = std::get_if<NotReadyFrame>(&*frame)) {
      on_not_ready(now, not_ready->lanes);
    } else {
      eliciting = true;  // a probe
    }
  }
  return broken || !reader.ok() ? Verdict::kBroken : Verdict::kTaken;
}

// The other side has no memory for these lanes: those that hold it go on, and must get through.
void Session::on_not_ready(Time now, std::uint16_t lanes) {
  const Duration pause = std::clamp<Duration>(4 * rtt_.smoothed(), kPauseMin, kPauseMax);
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    if ((lanes >> lane & 1) != 0) paused_until_[lane] = now + pause;
  probes_ = 0;
}

// False: it acknowledges what was never sent.
bool Session::on_ack(Time now, const Ack& ack) {
  const std::uint64_t in_flight = sent_.bytes_in_flight();
  const auto result = sent_.on_ack(now, ack, rtt_, *this);
  if (!result.valid) return false;
  if (!result.any_new) return true;
  Duration sample{};
  if (result.newest_is_new) {
    newest_acked_sent_ = result.newest_sent;
    sample = now - result.newest_sent;
    const Duration held = std::min(ack.delay * kAckDelayUnit, RttEstimator::kAckDelayMax);
    if (sample > held) sample -= held;
    sample = std::max(sample, Duration(1));
    rtt_.add(sample);
  }
  probes_ = 0;
  after_ack(now, result, sample, in_flight);
  return true;
}

void Session::after_ack(Time now, const SentPackets::AckResult& result, Duration rtt,
                        std::uint64_t in_flight) {
  congestion_.on_feedback(now, {.rtt = rtt,
                                .bytes_acked = result.bytes_acked,
                                .packets_acked = result.packets_acked,
                                .packets_lost = result.packets_lost,
                                .newest_acked = result.newest,
                                .next_packet = sent_.next(),
                                .in_flight = in_flight});
}

}  // namespace tims::link
