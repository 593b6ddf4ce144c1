#include "router/link/packets.h"

#include <algorithm>
#include <bit>

namespace tims::link {
namespace {

constexpr std::uint64_t kReorderingMax = 3;
constexpr std::uint64_t kTurn = std::uint64_t{1} << 32;

}  // namespace

std::uint64_t PacketWindow::expand(std::uint32_t wire) const {
  constexpr std::uint64_t kHalf = kTurn / 2;
  const std::uint64_t near = (next_ & ~(kTurn - 1)) | wire;
  if (near + kHalf <= next_) return near + kTurn;
  if (near > next_ + kHalf && near >= kTurn) return near - kTurn;
  return near;
}

bool PacketWindow::is_new(std::uint64_t packet) const {
  if (packet >= next_) return true;
  return packet + kWindow >= next_ && (seen_[packet % kWindow / 64] >> (packet % 64) & 1) == 0;
}

void PacketWindow::add(std::uint64_t packet, bool kept) {
  if (packet >= next_) {
    // The numbers in between have not been received; a jump beyond the window clears it.
    const std::uint64_t forget = std::min(packet + 1 - next_, kWindow);
    for (std::uint64_t i = packet + 1 - forget; i <= packet; ++i) {
      const std::uint64_t others = ~(std::uint64_t{1} << (i % 64));
      seen_[i % kWindow / 64] &= others;
      kept_[i % kWindow / 64] &= others;
    }
    next_ = packet + 1;
  }
  const std::uint64_t bit = std::uint64_t{1} << (packet % 64);
  seen_[packet % kWindow / 64] |= bit;
  if (kept) kept_[packet % kWindow / 64] |= bit;
}

void PacketWindow::fill(Ack& ack) const {
  ack.count = 0;
  std::uint64_t at = next_;
  while (ack.count < Ack::kRangesMax) {
    const std::uint64_t end = below(at, false);
    at = below(end, true);
    if (at == end) return;
    ack.ranges[ack.count++] = {static_cast<std::uint32_t>(at), static_cast<std::uint32_t>(end - 1)};
  }
}

// The end of the run below `packet` in which all packets were kept, or none. Processes 64 bits at
// a time.
std::uint64_t PacketWindow::below(std::uint64_t packet, bool kept) const {
  const std::uint64_t oldest = next_ - std::min(next_, kWindow);
  while (packet > oldest) {
    const std::uint64_t bits = kept_[(packet - 1) % kWindow / 64];
    const std::uint64_t in_word = (packet - 1) % 64 + 1;
    const auto run =
        static_cast<std::uint64_t>(std::countl_one((kept ? bits : ~bits) << (64 - in_word)));
    packet -= std::min({run, in_word, packet - oldest});
    if (run < in_word) break;
  }
  return packet;
}

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
  // It needs no acknowledgement and is not kept.
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
                                           PacketObserver& observer) {
  AckResult result;
  const auto whole = [this](std::uint32_t wire) {
    // The newest number sent that has these lower bits.
    const std::uint64_t last = next_ - 1;
    return last - static_cast<std::uint32_t>(static_cast<std::uint32_t>(last) - wire);
  };
  if (next_ == 0) return result;
  // Each range is below the one before: so none costs the work of another again.
  std::uint64_t above = next_;
  for (std::size_t i = 0; i < ack.count; ++i) {
    // A number above all sent ones is mapped nearly 2^32 too low.
    const std::uint64_t last = whole(ack.ranges[i].last);
    const std::uint32_t more = ack.ranges[i].last - ack.ranges[i].first;
    if (last >= above || next_ - last > kTurn / 2 || more > last) return result;
    above = last - more;
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
      observer.on_packet_acked(packet);
    }
  }
  largest_acked_ = std::max(largest_acked_, result.newest + 1);
  find_lost(now, rtt, observer, result);
  return result;
}

SentPackets::AckResult SentPackets::detect_lost(Time now, const RttEstimator& rtt,
                                                PacketObserver& observer) {
  AckResult result;
  find_lost(now, rtt, observer, result);
  return result;
}

void SentPackets::find_lost(Time now, const RttEstimator& rtt, PacketObserver& observer,
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
      ++result.packets_lost;
      observer.on_packet_lost(packet);
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

void SentPackets::forget_all(PacketObserver& observer) {
  for (std::uint64_t n = first_; n < next_; ++n) {
    SentPacket& packet = at(n);
    if (packet.state != SentPacket::State::kInFlight) continue;
    resolve(packet);
    observer.on_packet_lost(packet);
  }
  first_ = next_;
  loss_time_ = kNever;
}

}  // namespace tims::link
