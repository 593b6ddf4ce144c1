#include "router/link/sent_packets.h"

#include <algorithm>

namespace tims::link {
namespace {

constexpr std::uint64_t kReorderingMax = 3;
constexpr std::uint64_t kTurn = std::uint64_t{1} << 32;

}  // namespace

SentPacket& SentPackets::add() {
  if (next_ - first_ == ring_.size()) {
    std::vector<SentPacket> larger(std::max<std::size_t>(64, 2 * ring_.size()));
    for (std::uint64_t i = first_; i < next_; ++i) larger[i & (larger.size() - 1)] = at(i);
    ring_ = std::move(larger);
  }
  SentPacket& packet = at(next_++);
  packet = {};
  return packet;
}

void SentPackets::sent(SentPacket& packet) {
  if (packet.elicits_ack) {
    packet.state = SentPacket::State::kInFlight;
    ++eliciting_in_flight_;
    bytes_in_flight_ += packet.size;
    last_eliciting_ = packet.at;
    return;
  }
  // Nobody need acknowledge it, and it is not kept.
  skip_resolved();
}

void SentPackets::skip_resolved() {
  while (first_ < next_ && at(first_).state == SentPacket::State::kResolved) ++first_;
}

void SentPackets::resolve(SentPacket& packet) {
  packet.state = SentPacket::State::kResolved;
  --eliciting_in_flight_;
  bytes_in_flight_ -= packet.size;
}

SentPackets::AckResult SentPackets::on_ack(Time now, const Ack& ack, const RttEstimator& rtt,
                                           PacketFate& fate) {
  AckResult result;
  const auto whole = [this](std::uint32_t wire) {
    // Of the numbers with these lower bits, the newest that was sent.
    const std::uint64_t last = next_ - 1;
    return last - static_cast<std::uint32_t>(static_cast<std::uint32_t>(last) - wire);
  };
  if (next_ == 0) return result;
  for (std::size_t i = 0; i < ack.count; ++i) {
    // A number above all that were sent comes out nearly a whole turn too low.
    const std::uint64_t last = whole(ack.ranges[i].last);
    const std::uint32_t more = ack.ranges[i].last - ack.ranges[i].first;
    if (last >= next_ || next_ - last > kTurn / 2 || more > last) return result;
  }
  result.valid = true;
  for (std::size_t i = 0; i < ack.count; ++i) {
    const std::uint64_t last = whole(ack.ranges[i].last);
    const std::uint32_t more = ack.ranges[i].last - ack.ranges[i].first;
    const std::uint64_t first = last - more;
    if (i == 0) result.newest = last;
    for (std::uint64_t n = std::max(first, first_); n <= last; ++n) {
      SentPacket& packet = at(n);
      if (packet.state != SentPacket::State::kInFlight) continue;
      resolve(packet);
      result.any_new = true;
      result.bytes_acked += packet.size;
      ++result.packets_acked;
      if (n == result.newest) {
        result.newest_is_new = true;
        result.newest_sent = packet.at;
      }
      fate.on_packet_acked(packet);
    }
  }
  largest_acked_ = std::max(largest_acked_, result.newest + 1);
  find_lost(now, rtt, fate, result);
  return result;
}

SentPackets::AckResult SentPackets::detect_lost(Time now, const RttEstimator& rtt,
                                                PacketFate& fate) {
  AckResult result;
  find_lost(now, rtt, fate, result);
  return result;
}

void SentPackets::find_lost(Time now, const RttEstimator& rtt, PacketFate& fate,
                            AckResult& result) {
  loss_time_ = kNever;
  const Duration delay = rtt.loss_delay();
  for (std::uint64_t n = first_; n < largest_acked_; ++n) {
    SentPacket& packet = at(n);
    if (packet.state == SentPacket::State::kInFlight) {
      const bool overtaken = n + kReorderingMax < largest_acked_;
      if (!overtaken && packet.at + delay > now) {
        loss_time_ = std::min(loss_time_, packet.at + delay);
        continue;
      }
      resolve(packet);
      result.bytes_lost += packet.size;
      ++result.packets_lost;
      fate.on_packet_lost(packet);
    }
  }
  skip_resolved();
}

const SentPacket* SentPackets::oldest_in_flight() const {
  for (std::uint64_t n = first_; n < next_; ++n) {
    const SentPacket& packet = ring_[n & (ring_.size() - 1)];
    if (packet.state == SentPacket::State::kInFlight) return &packet;
  }
  return nullptr;
}

void SentPackets::forget_all(PacketFate& fate) {
  for (std::uint64_t n = first_; n < next_; ++n) {
    SentPacket& packet = at(n);
    if (packet.state != SentPacket::State::kInFlight) continue;
    resolve(packet);
    fate.on_packet_lost(packet);
  }
  first_ = next_;
  loss_time_ = kNever;
}

}  // namespace tims::link
