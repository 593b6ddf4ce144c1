#include "router/link/link_session.h"

#include <algorithm>
#include <utility>

#include "router/link/datagram.h"
#include "router/link/transport.h"

namespace tims::link {
namespace {

using namespace std::chrono_literals;

constexpr Duration kExpiryEvery = std::chrono::milliseconds(50);

// Array of make(0), make(1), ...
template <std::size_t size, typename Make>
auto array_of(Make make) {
  return [&]<std::size_t... i>(std::index_sequence<i...>) {
    return std::array<std::invoke_result_t<Make, std::size_t>, size>{make(i)...};
  }(std::make_index_sequence<size>());
}

// Pause of a lane for which the other side has no memory.
constexpr Duration kPauseMin = 20ms;
constexpr Duration kPauseMax = 500ms;

constexpr std::size_t kUrgentLane = 5;  // lanes from here on may exceed the window
constexpr std::size_t kUpperLane = 4;   // lanes from here on may also use the reserve of the rate
constexpr std::uint64_t kBurstBytes = 64 << 10;
// Amount sent between two waits on a fast link: setting a timer costs as much as sending a burst
// of datagrams.
constexpr std::uint64_t kPacerDepthMax = 4 * kBurstBytes;
// Bytes per second above which the largest datagram takes less than half a millisecond.
constexpr std::uint64_t kJumboFrom = 2000 * kDatagramMax;
// Below, acknowledgements pace the sender.
constexpr Duration kPacedFrom = std::chrono::milliseconds(1);

}  // namespace

LinkSession::LinkSession(core::BlockPool& pool, MessageMemory& memory,
                         std::vector<MessageBuffer>& done, const LinkSessionSettings& settings,
                         ArrivalObserver& arrivals, LossObserver& losses)
    : settings_(settings),
      arrivals_(arrivals),
      losses_(losses),
      lanes_(array_of<kLanes>([&](std::size_t) { return LaneSender(pool, losses); })),
      samples_(array_of<core::kClasses>([&](std::size_t) { return SampleSender(pool, losses); })),
      reassembly_{pool, memory, done, settings.message_max},
      receivers_(array_of<kLanes>([&](std::size_t lane) {
        return LaneReceiver(reassembly_, arrivals, lane == kControlLane);
      })),
      sample_receiver_(reassembly_, arrivals) {
  lanes_[kControlLane].set_window(kControlWindow);
  configure(settings);
}

void LinkSession::configure(const LinkSessionSettings& settings) {
  settings_ = settings;
  reassembly_.message_max = settings.message_max;
  reassembly_.lifetimes = &settings_.lifetimes;
  for (std::size_t lane = 0; lane < core::kClasses; ++lane)
    lanes_[lane].set_lifetimes(&settings_.lifetimes);
}

std::uint64_t LinkSession::queued_bytes(std::size_t lane) const {
  return lanes_[lane].bytes() + (lane < core::kClasses ? samples_[lane].bytes() : 0);
}

std::uint64_t LinkSession::queued_bytes() const {
  std::uint64_t sum = 0;
  for (const std::size_t lane : occupied_) sum += queued_bytes(lane);
  return sum;
}

// --- time

Time LinkSession::probe_deadline() const {
  const Time last = sent_.last_eliciting();
  if (last == kNever) return kNever;
  const Duration wait = rtt_.probe_timeout() * (1 << std::min(probes_, 4));
  return last + std::min<Duration>(wait, std::chrono::seconds(1));
}

Time LinkSession::next_timeout(Time now) {
  forget_idle_lanes();
  Time next = occupied_.empty() && !reassembly_.is_used() ? kNever : next_expiry_;
  if (!open_) return next;
  next = std::min({next, ack_at_, sent_.loss_time(), probe_deadline()});
  if (rtt_.known()) next = std::min(next, mtu_.next_probe(datagram_max()));
  for (const std::size_t lane : occupied_) {
    if (wants_to_send(lane)) next = std::min(next, ready_at(now, lane));
  }
  return next;
}

void LinkSession::on_timeout(Time now) {
  if (now >= next_expiry_) {
    next_expiry_ = now + kExpiryEvery;
    for (std::size_t lane = 0; lane < core::kClasses; ++lane) {
      lanes_[lane].expire(now, settings_.lifetime);
      samples_[lane].expire(now, settings_.lifetime);
    }
    sample_receiver_.expire(now);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      (void)receivers_[lane].retry(now);
      if (const auto header = receivers_[lane].give_up_stalled(now))
        losses_.on_lost(now, *header, core::Outcome::kIncomplete);
    }
  }
  if (ack_at_ <= now) ack_now_ = true;
  if (!open_) return;
  if (sent_.loss_time() <= now) {
    const std::uint64_t in_flight = sent_.bytes_in_flight();
    after_ack(now, sent_.detect_lost(now, rtt_, *this), Duration::zero(), in_flight);
  }
  if (probe_deadline() <= now) {
    ++probes_;
    probe_packets_ = 2;
    if (probes_ == 3) congestion_.on_silence();
    // Sends the oldest packet's contents again to elicit an acknowledgement.
    if (const SentPacket* oldest = sent_.oldest_in_flight()) {
      const SentPacket again = *oldest;
      for (std::size_t i = 0; i < again.pieces; ++i) on_lost(again.piece[i]);
      if (again.skip_lane < kLanes) lanes_[again.skip_lane].on_skip_lost();
    }
  }
}

void LinkSession::on_new_path(Time now, PathKind kind) {
  forget_path(now);
  // DDS and TCP divide what they carry themselves.
  if (kind != PathKind::kUdp) mtu_.fix(kDatagramMax);
}

void LinkSession::forget_path(Time now) {
  rtt_.reset();
  congestion_ = Congestion(kDatagramBase);
  mtu_.reset(now);
  probes_ = 0;
  sent_.forget_all(*this);
}

void LinkSession::reset(Time now, core::Outcome why) {
  sent_ = SentPackets();
  for (LaneSender& lane : lanes_) lane.clear(now, why);
  for (SampleSender& samples : samples_) samples.clear(now, why);
  for (LaneReceiver& receiver : receivers_) receiver.clear();
  sample_receiver_.clear();
  window_ = PacketWindow();
  unacked_ = 0;
  not_ready_ = 0;
  paused_until_ = {};
  ack_now_ = false;
  ack_at_ = kNever;
  measured_next_ = 0;
  measured_in_ = counters_.packets_in - questions_in_;
  measured_questions_ = 0;
  questions_out_ = 0;
  forget_path(now);
}

// --- for the next router

void LinkSession::save(StateWriter& to) const {
  to.put(sent_.next(), window_.next(), sample_receiver_.next(), last_sample_, questions_out());
  for (const LaneSender& lane : lanes_) lane.save(to);
  for (const LaneReceiver& receiver : receivers_) receiver.save(to);
}

bool LinkSession::restore(Time now, StateReader& from) {
  constexpr std::uint64_t kNumberMax = std::uint64_t{1} << 62;
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::uint64_t samples = 0;
  std::uint8_t questions = 0;
  from.get(sent, received, samples, last_sample_, questions);
  if (!from.ok() || std::max({sent, received, samples}) > kNumberMax) return false;
  sent_.continue_at(sent);
  window_.continue_at(received);
  sample_receiver_.continue_at(samples);
  measured_next_ = received;
  questions_out_ = questions;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    if (!lanes_[lane].restore(from)) return false;
    occupied_.add(lane);
  }
  queued_at_most_ = queued_bytes();
  next_expiry_ = now + kExpiryEvery;
  return std::ranges::all_of(receivers_,
                             [&](LaneReceiver& lane) { return lane.restore(now, from); });
}

// Path challenges are not counted as lost, because some of the paths may be dead.
void LinkSession::measure_loss(std::uint8_t questions) {
  const std::uint64_t asked =
      (kQuestionsModulo + questions - measured_questions_) % kQuestionsModulo;
  const std::uint64_t sent = window_.next() - measured_next_;
  const std::uint64_t expected = sent - std::min(asked, sent);
  if (expected < 4) return;
  const std::uint64_t come = counters_.packets_in - questions_in_;
  const std::uint64_t got = std::min(come - measured_in_, expected);
  const auto permille = static_cast<std::uint16_t>((expected - got) * 1000 / expected);
  loss_permille_ = static_cast<std::uint16_t>((3 * loss_permille_ + permille) / 4);
  measured_next_ = window_.next();
  measured_in_ = come;
  measured_questions_ = questions;
}

// --- fate of sent packets

void LinkSession::on_acked(const SentPacket::Piece& piece) {
  const Range range{piece.offset, piece.offset + piece.size};
  if (piece.lane < kLanes) {
    lanes_[piece.lane].on_acked(range);
  } else {
    samples_[piece.lane - kLanes].on_acked(range);
  }
}

void LinkSession::on_lost(const SentPacket::Piece& piece) {
  const Range range{piece.offset, piece.offset + piece.size};
  if (piece.lane < kLanes) {
    lanes_[piece.lane].on_lost(range);
  } else {
    samples_[piece.lane - kLanes].on_lost(range);
  }
}

void LinkSession::on_packet_acked(const SentPacket& packet) {
  for (std::size_t i = 0; i < packet.pieces; ++i) on_acked(packet.piece[i]);
  if (packet.skip_lane < kLanes) lanes_[packet.skip_lane].on_skip_acked(packet.skip_to);
  mtu_.on_acked(packet.size, packet.at);
  if (packet.probe != 0) {
    mtu_.on_probe_acked(newest_at_, packet.probe);
  }
}

void LinkSession::on_packet_lost(const SentPacket& packet) {
  ++counters_.packets_lost;
  for (std::size_t i = 0; i < packet.pieces; ++i) on_lost(packet.piece[i]);
  if (packet.skip_lane < kLanes) lanes_[packet.skip_lane].on_skip_lost();
  if (packet.probe != 0) {
    mtu_.on_probe_lost(newest_at_);
  } else {
    (void)mtu_.on_lost(newest_at_, packet.size, packet.at);
  }
}

// --- receiving

bool LinkSession::open(Time now, Data& data) {
  switch (keys_.open(now, window_.expand(data.header.packet), data)) {
    case SessionKeys::Verdict::kForged:
      ++counters_.packets_forged;
      return false;
    case SessionKeys::Verdict::kOldKey:
      ++counters_.packets_old_key;
      return false;
    case SessionKeys::Verdict::kOpened:
      break;
  }
  return true;
}

LinkSession::Verdict LinkSession::on_data(Time now, const Data& data) {
  const std::uint64_t number = window_.expand(data.header.packet);
  const bool newest = number >= window_.next();
  const bool in_order = number == window_.next();
  if (newest) newest_at_ = now;
  bool eliciting = false;
  bool keep = true;
  const Verdict verdict = on_frames(now, data, eliciting, keep);
  if (verdict == Verdict::kBroken) return verdict;
  window_.add(number, keep);
  if (!keep) {
    ++counters_.packets_refused;
    if (not_ready_ != 0) ack_now_ = true;
    return Verdict::kTaken;
  }
  ++counters_.packets_in;
  counters_.bytes_in += kDataHeaderSize + data.frames.size() + keys_.overhead();
  if (!eliciting) return verdict;
  ++unacked_;
  // Acknowledge immediately when a packet is missing, so that the sender learns it soon;
  // otherwise every second packet, or after a short delay.
  if (!in_order || unacked_ >= 2) ack_now_ = true;
  ack_at_ = std::min(ack_at_, now + RttEstimator::kAckDelayMax);
  return verdict;
}

LinkSession::Verdict LinkSession::on_frames(Time now, const Data& data, bool& eliciting,
                                            bool& keep) {
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
                   receivers_[stream->lane].on_bytes(now, stream->offset, stream->bytes));
    } else if (const auto* sample = std::get_if<SampleFrame>(&*frame)) {
      eliciting = true;
      broken = !sample_receiver_.on_frame(now, *sample);
    } else if (const auto* ack = std::get_if<Ack>(&*frame)) {
      broken = !on_ack(now, *ack);
    } else if (const auto* skip = std::get_if<SkipFrame>(&*frame)) {
      lane_verdict(skip->lane, receivers_[skip->lane].on_skip(now, skip->to));
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
    } else if (const auto* pause = std::get_if<PauseFrame>(&*frame)) {
      arrivals_.on_frame(now, *pause);
    } else if (const auto* not_ready = std::get_if<NotReadyFrame>(&*frame)) {
      on_not_ready(now, not_ready->lanes);
    } else {
      eliciting = true;  // a probe needs an acknowledgement
    }
  }
  return broken || !reader.ok() ? Verdict::kBroken : Verdict::kTaken;
}

// The other side has no memory for these lanes: pause them, so that the lanes that hold the
// memory get through.
void LinkSession::on_not_ready(Time now, std::uint16_t lanes) {
  const Duration pause = std::clamp<Duration>(4 * rtt_.smoothed(), kPauseMin, kPauseMax);
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    if ((lanes >> lane & 1) != 0) paused_until_[lane] = now + pause;
  probes_ = 0;
}

// Returns false when it acknowledges packets that were never sent.
bool LinkSession::on_ack(Time now, const Ack& ack) {
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

void LinkSession::after_ack(Time now, const SentPackets::AckResult& result, Duration rtt,
                            std::uint64_t in_flight) {
  congestion_.on_feedback(now, {.rtt = rtt,
                                .bytes_acked = result.bytes_acked,
                                .packets_acked = result.packets_acked,
                                .packets_lost = result.packets_lost,
                                .newest_acked = result.newest,
                                .next_packet = sent_.next(),
                                .in_flight = in_flight});
}

// --- choice of what to send

// A packet being built.
struct LinkSession::Packet {
  std::span<std::byte> datagram;
  ByteWriter out;  // leaves room for the tag
  SentPacket record{};

  [[nodiscard]] bool takes_piece(std::size_t header) const {
    return out.room() > header && record.pieces < SentPacket::kPiecesMax;
  }
};

LinkSession::Packet LinkSession::packet_in(std::span<std::byte> out) const {
  Packet packet{.datagram = out, .out = ByteWriter(out.first(out.size() - keys_.overhead()))};
  packet.out.reserve(kDataHeaderSize);
  return packet;
}

// --- waiting messages

core::Outcome LinkSession::send(Time now, const RecordPrefix& prefix, const Header& header,
                                std::span<const std::byte> message) {
  const std::size_t lane = settings_.classes.of(header);
  const bool sample = (header.flags & flag::kStream) != 0;
  if (!make_room(now, lane, message.size())) return core::Outcome::kQueueFull;
  occupied_.add(lane);
  queued_at_most_ += record_size(message.size());
  if (next_expiry_ < now) next_expiry_ = now + std::chrono::milliseconds(50);
  if (sample) {
    samples_[lane].push(now, prefix.of_sample(), header, message);
  } else {
    lanes_[lane].push(now, prefix, message, committed_max());
  }
  return core::Outcome::kDelivered;
}

// Drops messages that are no more important than one of this lane until the lane has room. Drops
// nothing when that would not be enough.
bool LinkSession::make_room(Time now, std::size_t lane, std::size_t message) {
  constexpr std::uint64_t kBlock = core::BlockPool::kBlockSize;
  // A link may use no more of the shared memory than it leaves to others.
  const auto has_room = [&] {
    const std::uint64_t free = reassembly_.pool.available() * kBlock;
    return queued_at_most_ + message <= std::min(settings_.queue_bytes_max, free) &&
           lanes_[lane].has_room(message);
  };
  if (has_room()) return true;
  // Recounted only when it may matter: acknowledgements make the bound too high, never too low.
  queued_at_most_ = queued_bytes();
  std::uint64_t may_go = 0;
  for (std::size_t lower = 0; lower <= lane; ++lower)
    may_go += lanes_[lower].waiting_bytes() + samples_[lower].droppable_bytes();
  const std::uint64_t free = (reassembly_.pool.available() + may_go / kBlock) * kBlock;
  if (queued_at_most_ - may_go + message > std::min(settings_.queue_bytes_max, free)) return false;
  while (!has_room() && drop_one(now, lane)) queued_at_most_ = queued_bytes();
  return has_room();
}

// Drops one message that is no more important than one of this lane. Returns false when there is
// none.
bool LinkSession::drop_one(Time now, std::size_t lane) {
  for (std::size_t lower = 0; lower <= lane; ++lower) {
    if (samples_[lower].drop_one(now)) return true;
    if (lanes_[lower].has_waiting()) {
      losses_.on_lost(now, lanes_[lower].drop_oldest(), core::Outcome::kQueueReplaced);
      return true;
    }
  }
  return false;
}

void LinkSession::send_control(Time now, std::span<const std::byte> message) {
  if (!lanes_[kControlLane].has_room(message.size())) return;
  occupied_.add(kControlLane);
  lanes_[kControlLane].push(now, {}, message, ~std::uint64_t{0});
}

std::uint64_t LinkSession::committed_max() const {
  return std::max<std::uint64_t>(2 * kBurstBytes, congestion_.window());
}

// --- permission to send

std::uint64_t LinkSession::rate() const {
  const std::uint64_t rate = congestion_.rate(rtt_.smoothed());
  return settings_.rate != 0 ? std::min(rate, settings_.rate) : rate;
}

std::size_t LinkSession::datagram_max() const {
  return rate() < kJumboFrom ? kDatagramEthernet : kDatagramMax;
}

std::size_t LinkSession::datagram_size() const { return std::min(mtu_.size(), datagram_max()); }

void LinkSession::set_rates() {
  congestion_.set_datagram(datagram_size());
  const std::size_t datagram = datagram_size() + kDatagramOverhead;
  if (settings_.rate != 0) {
    const std::uint64_t depth = std::max<std::uint64_t>(datagram, settings_.rate / 4000);
    cap_.set(settings_.rate, depth);
    // Sending two at once halves the wake-ups, and an urgent message waits for at most these two.
    lower_cap_.set(settings_.rate * (100U - settings_.reserve) / 100, 2 * depth);
  } else {
    cap_.set(0, 0);
    lower_cap_.set(0, 0);
  }
  if (rtt_.smoothed() < kPacedFrom || !rtt_.known()) {
    pacer_.set(0, 0);
    return;
  }
  const std::uint64_t rate = congestion_.pacing_rate(rtt_.smoothed());
  pacer_.set(rate, std::clamp<std::uint64_t>(rate / 1000, 2 * datagram, kPacerDepthMax));
}

// The time at which this lane may send; kNever: only an acknowledgement can change that.
Time LinkSession::ready_at(Time now, std::size_t lane) {
  if (sent_.full()) return kNever;
  const Time cap = std::max(cap_.ready_at(now), paused_until_[lane]);
  if (probe_packets_ > 0) return cap;
  const std::uint64_t in_flight = sent_.bytes_in_flight();
  if (lane >= kUrgentLane) {
    // Lanes without memory at the other side do not repeat: the lanes below, which hold that
    // memory, must get through.
    const std::uint64_t window =
        lanes_[lane].repeats() ? congestion_.window() : congestion_.urgent_window();
    return in_flight < window ? cap : kNever;
  }
  if (!congestion_.may_send(in_flight)) return kNever;
  const Time paced = std::max(cap, pacer_.ready_at(now));
  return lane < kUpperLane ? std::max(paced, lower_cap_.ready_at(now)) : paced;
}

bool LinkSession::wants_to_send(std::size_t lane) const {
  if (lanes_[lane].wants_to_send() || lanes_[lane].skip()) return true;
  return has_samples(lane);
}

bool LinkSession::has_samples(std::size_t lane) const {
  return lane < core::kClasses && samples_[lane].wants_to_send();
}

bool LinkSession::has_something_to_send() const {
  if (ack_now_ || probe_packets_ > 0) return true;
  for (const std::size_t lane : occupied_) {
    if (wants_to_send(lane)) return true;
  }
  return false;
}

bool LinkSession::is_idle(std::size_t lane) const {
  return lanes_[lane].is_idle() && (lane == kControlLane || samples_[lane].is_idle());
}

void LinkSession::forget_idle_lanes() {
  for (const std::size_t lane : occupied_) {
    if (is_idle(lane)) occupied_.remove(lane);
  }
}

// --- building a packet

std::size_t LinkSession::build(Time now, std::uint64_t token, std::span<std::byte> out,
                               const KeepAlive* keep_alive) {
  if (keep_alive == nullptr && !has_something_to_send()) return 0;
  const std::size_t size = std::min(out.size(), size_for(keep_alive != nullptr));
  Packet packet = packet_in(out.first(size));
  last_lane_ = kControlLane;
  set_rates();
  if (keep_alive != nullptr) put(packet.out, *keep_alive);
  if (open_) {
    if (unacked_ > 0 || ack_now_) put_ack(now, packet);
    put_not_ready(packet);
    put_skip(packet);
    put_lanes(now, packet);
    if (probe_packets_ > 0 && !packet.record.elicits_ack) put_ping(packet);
  }
  const bool worth_it = keep_alive != nullptr || packet.record.elicits_ack || ack_now_;
  if (!worth_it) return 0;
  if (open_) {
    unacked_ = 0;
    ack_now_ = false;
    ack_at_ = kNever;
  }
  return finish(now, token, packet);
}

// Keep-alives pass every path, whatever is sent with them. Probes after silence are small, because
// the path may be losing large datagrams; the second and later ones are as small as keep-alives.
std::size_t LinkSession::size_for(bool keeps_alive) const {
  std::size_t most = kDatagramMax;
  if (probe_packets_ > 0) most = kDatagramBase;
  if (keeps_alive || (probe_packets_ > 0 && probes_ > 1)) most = kDatagramMin;
  return std::min(most, datagram_size());
}

// A frame whose only purpose is to request an acknowledgement.
void LinkSession::put_ping(Packet& packet) {
  if (packet.out.room() == 0) return;
  packet.out.put(FrameType::kProbe);
  packet.record.elicits_ack = true;
}

void LinkSession::put_ack(Time now, Packet& packet) {
  Ack ack;
  window_.fill(ack);
  if (ack.count == 0) return;
  ack.delay = static_cast<std::uint16_t>(
      std::clamp<std::int64_t>((now - newest_at_) / kAckDelayUnit, 0, 0xFFFF));
  put(packet.out, ack);
}

void LinkSession::put_not_ready(Packet& packet) {
  if (not_ready_ == 0 || packet.out.room() < kNotReadySize) return;
  put(packet.out, NotReadyFrame{std::exchange(not_ready_, std::uint16_t{0})});
}

void LinkSession::put_skip(Packet& packet) {
  for (const std::size_t lane : occupied_) {
    const auto to = lanes_[lane].skip();
    if (!to || packet.record.skip_lane < kLanes || packet.out.room() < kSkipSize) continue;
    put(packet.out, SkipFrame{static_cast<std::uint8_t>(lane), *to});
    packet.record.skip_lane = static_cast<std::uint8_t>(lane);
    packet.record.skip_to = *to;
    packet.record.elicits_ack = true;
    lanes_[lane].on_skip_sent();
  }
}

void LinkSession::put_lanes(Time now, Packet& packet) {
  bool first = true;
  for (const std::size_t lane : occupied_) {
    if (!wants_to_send(lane)) continue;
    const bool samples = has_samples(lane);
    if (ready_at(now, lane) > now) {
      if (samples) samples_[lane].congested();
      continue;
    }
    if (std::exchange(first, false)) last_lane_ = lane;
    sample_first_ = !sample_first_;
    if (sample_first_ && samples) {
      while (put_sample(now, packet, lane)) {
      }
    }
    while (put_stream(now, packet, lane)) {
    }
    if (!sample_first_ && samples) {
      while (put_sample(now, packet, lane)) {
      }
    }
  }
}

bool LinkSession::put_stream(Time now, Packet& packet, std::size_t lane) {
  if (!packet.takes_piece(kStreamHeaderSize)) return false;
  const auto range = lanes_[lane].take(now, packet.out.room() - kStreamHeaderSize, committed_max());
  if (!range) return false;
  const auto size = static_cast<std::size_t>(range->size());
  put_header(packet.out, static_cast<std::uint8_t>(lane), range->begin, size);
  lanes_[lane].read(*range, packet.out.reserve(size));
  counters_.lane_bytes_out[lane] += kStreamHeaderSize + size;
  packet.record.piece[packet.record.pieces++] = {.offset = range->begin,
                                                 .size = static_cast<std::uint16_t>(range->size()),
                                                 .lane = static_cast<std::uint8_t>(lane)};
  packet.record.elicits_ack = true;
  return true;
}

bool LinkSession::put_sample(Time now, Packet& packet, std::size_t message_class) {
  SampleSender& samples = samples_[message_class];
  if (packet.out.room() <= kSampleHeaderSize + kHeaderSize) return false;
  const auto piece = samples.next(packet.out.room() - kSampleHeaderSize, last_sample_);
  if (!piece) return false;
  if (!piece->is_sent_once()) {
    if (packet.record.pieces == SentPacket::kPiecesMax) return false;
    packet.record.piece[packet.record.pieces++] = {
        .offset = piece->at,
        .size = static_cast<std::uint16_t>(piece->size),
        .lane = static_cast<std::uint8_t>(kLanes + message_class)};
  }
  put_header(packet.out, piece->frame, piece->size);
  samples.read(*piece, packet.out.reserve(piece->size));
  samples.sent(now, *piece);
  counters_.lane_bytes_out[message_class] += kSampleHeaderSize + piece->size;
  if (piece->again) ++counters_.sample_repeats;
  packet.record.elicits_ack = true;
  return true;
}

// Nothing is sent before the handshake that brings the keys.
std::size_t LinkSession::finish(Time now, std::uint64_t token, Packet& packet) {
  if (keys_.are_locked()) return 0;
  const std::span<std::byte> datagram = packet.datagram.first(packet.out.size() + keys_.overhead());
  keys_.seal(now, token, sent_.next(), datagram);
  SentPacket& record = sent_.add();
  record = packet.record;
  record.at = now;
  record.size = static_cast<std::uint16_t>(datagram.size());
  sent_.sent(record);
  const std::size_t cost = datagram.size() + kDatagramOverhead;
  if (record.elicits_ack) {
    pacer_.take(cost);
    if (probe_packets_ > 0) --probe_packets_;
  }
  cap_.take(cost);
  lower_cap_.take(cost);
  ++counters_.packets_out;
  counters_.bytes_out += datagram.size();
  return datagram.size();
}

std::size_t LinkSession::build_probe(Time now, std::uint64_t token, std::span<std::byte> to) {
  if (!open_ || !rtt_.known()) return 0;
  const std::size_t size = mtu_.probe(now, datagram_max());
  if (size == 0 || size > to.size()) return 0;
  Packet packet = packet_in(to.first(size));
  packet.out.put(FrameType::kProbe);
  std::ranges::fill(packet.out.reserve(packet.out.room()), std::byte{0});
  packet.record.probe = static_cast<std::uint16_t>(size);
  packet.record.elicits_ack = true;
  mtu_.on_probe_sent(size);
  return finish(now, token, packet);
}

std::size_t LinkSession::build_nonce(Time now, std::uint64_t token, FrameType type,
                                     std::uint64_t nonce, std::span<std::byte> out) {
  Packet packet = packet_in(out);
  put_challenge(packet.out, type, nonce);
  const std::size_t size = finish(now, token, packet);
  if (size > 0) ++questions_out_;
  return size;
}

std::size_t LinkSession::build_last(Time now, std::uint64_t token, const LastFrame& frame,
                                    std::span<std::byte> out) {
  Packet packet = packet_in(out);
  std::visit([&](const auto& last) { put(packet.out, last); }, frame);
  return finish(now, token, packet);
}

}  // namespace tims::link
