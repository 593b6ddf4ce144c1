#include "router/link/session.h"

#include <algorithm>
#include <utility>

namespace tims::link {
namespace {

constexpr Duration kExpiryEvery = std::chrono::milliseconds(50);

template <typename T, std::size_t... i, typename Argument>
std::array<T, sizeof...(i)> array_of(std::index_sequence<i...>, Argument& argument) {
  return {((void)i, T(argument))...};
}
template <typename T, std::size_t size, typename Argument>
std::array<T, size> array_of(Argument& argument) {
  return array_of<T>(std::make_index_sequence<size>(), argument);
}

}  // namespace

Session::Session(core::BlockPool& pool, MessageMemory& memory, std::vector<MessageBuffer>& done,
                 const SessionSettings& settings, Arrivals& arrivals, Losses& losses)
    : settings_(settings),
      arrivals_(arrivals),
      losses_(losses),
      lanes_(array_of<LaneSender, kLanes>(pool)),
      samples_(array_of<SampleSender, core::kClasses>(pool)),
      assembly_{pool, memory, done, settings.message_max},
      receivers_(array_of<LaneReceiver, kLanes>(assembly_)),
      sample_receiver_(assembly_) {
  lanes_[kControlLane].set_window(kControlWindow);
  configure(settings);
}

void Session::configure(const SessionSettings& settings) {
  settings_ = settings;
  assembly_.message_max = settings.message_max;
}

std::uint64_t Session::queued_bytes(std::size_t lane) const {
  return lanes_[lane].bytes() + (lane < core::kClasses ? samples_[lane].bytes() : 0);
}

std::uint64_t Session::queued_bytes() const {
  std::uint64_t sum = 0;
  for (const std::size_t lane : occupied_) sum += queued_bytes(lane);
  return sum;
}

// --- time

Time Session::probe_deadline() const {
  const Time last = sent_.last_eliciting();
  if (last == kNever) return kNever;
  const Duration wait = rtt_.probe_timeout() * (1 << std::min(probes_, 4));
  return last + std::min<Duration>(wait, std::chrono::seconds(1));
}

Time Session::next_timeout(Time now) {
  forget_idle_lanes();
  Time next = occupied_.empty() && !assembly_.is_used() ? kNever : next_expiry_;
  if (!open_) return next;
  next = std::min({next, ack_at_, sent_.loss_time(), probe_deadline()});
  if (rtt_.known()) next = std::min(next, mtu_.next_probe(datagram_max()));
  for (const std::size_t lane : occupied_) {
    if (wants_to_send(lane)) next = std::min(next, ready_at(now, lane));
  }
  return next;
}

void Session::on_timeout(Time now) {
  if (now >= next_expiry_) {
    next_expiry_ = now + kExpiryEvery;
    for (std::size_t lane = 0; lane < core::kClasses; ++lane) {
      lanes_[lane].expire(now, settings_.lifetime, losses_);
      samples_[lane].expire(now, settings_.lifetime, losses_);
    }
    sample_receiver_.expire(now);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      (void)receivers_[lane].retry(now, lane == kControlLane, arrivals_);
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
    // The oldest again, as something worth an acknowledgement.
    if (const SentPacket* oldest = sent_.oldest_in_flight()) {
      const SentPacket again = *oldest;
      for (std::size_t i = 0; i < again.pieces; ++i) {
        const SentPacket::Piece& piece = again.piece[i];
        lanes_[piece.lane].on_lost({piece.offset, piece.offset + piece.size});
      }
      if (again.skip_lane < kLanes) lanes_[again.skip_lane].on_skip_lost();
    }
  }
}

void Session::on_new_path(Time now, PathKind kind) {
  forget_path(now);
  // DDS cuts what it sends by itself.
  if (kind == PathKind::kDds) mtu_.fix(kDatagramMax);
}

void Session::forget_path(Time now) {
  rtt_.reset();
  congestion_ = Congestion(kDatagramBase);
  mtu_.reset(now);
  probes_ = 0;
  sent_.forget_all(*this);
}

void Session::reset(Time now, core::Outcome why) {
  sent_ = SentPackets();
  for (LaneSender& lane : lanes_) lane.clear(now, why, losses_);
  for (SampleSender& samples : samples_) samples.clear(now, why, losses_);
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

// Of what asks about ways nothing is expected: some of them may be dead.
void Session::measure_loss(std::uint8_t questions) {
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

// --- what became of packets

void Session::on_packet_acked(const SentPacket& packet) {
  for (std::size_t i = 0; i < packet.pieces; ++i) {
    const SentPacket::Piece& piece = packet.piece[i];
    lanes_[piece.lane].on_acked({piece.offset, piece.offset + piece.size});
  }
  if (packet.skip_lane < kLanes) lanes_[packet.skip_lane].on_skip_acked(packet.skip_to);
  mtu_.on_acked(packet.size);
  if (packet.probe != 0) {
    mtu_.on_probe_acked(newest_at_, packet.probe);
  }
}

void Session::on_packet_lost(const SentPacket& packet) {
  ++counters_.packets_lost;
  for (std::size_t i = 0; i < packet.pieces; ++i) {
    const SentPacket::Piece& piece = packet.piece[i];
    lanes_[piece.lane].on_lost({piece.offset, piece.offset + piece.size});
  }
  if (packet.skip_lane < kLanes) lanes_[packet.skip_lane].on_skip_lost();
  if (packet.probe != 0) {
    mtu_.on_probe_lost(newest_at_);
  } else {
    (void)mtu_.on_lost(newest_at_, packet.size);
  }
}

}  // namespace tims::link
