// Packets by number: those of the other side that have come (PacketWindow), and ours of which
// nothing is known yet (SentPackets).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "router/link/buffers.h"
#include "router/link/estimators.h"
#include "router/link/frame.h"
#include "tims/time.h"

namespace tims::link {

// Which of the other side's packets have come: throws out what comes twice, and says what is to be
// acknowledged. Remembers the newest kWindow numbers; what is older counts as come twice.
class PacketWindow {
 public:
  static constexpr std::uint64_t kWindow = 4096;

  // The whole number behind the 32 bits on the wire: the one nearest to what is expected next.
  [[nodiscard]] std::uint64_t expand(std::uint32_t wire) const;

  [[nodiscard]] bool is_new(std::uint64_t packet) const;
  void add(std::uint64_t packet);  // it is new

  [[nodiscard]] std::uint64_t next() const { return next_; }  // one above the newest
  // The newest ranges; nothing while no packet has come.
  void fill(Ack& ack) const;

 private:
  [[nodiscard]] std::uint64_t below(std::uint64_t packet, bool come) const;
  [[nodiscard]] bool seen(std::uint64_t packet) const {
    return (bits_[packet % kWindow / 64] >> (packet % 64) & 1) != 0;
  }

  std::uint64_t next_ = 0;
  std::array<std::uint64_t, kWindow / 64> bits_{};
};

// The packets that were sent and of which nothing is known yet: what was in them, until they are
// acknowledged or count as lost. Loss detection is that of RFC 9002, section 6.1: three packets
// sent later have arrived, or one sent later and enough time has passed.
struct SentPacket {
  static constexpr std::size_t kPiecesMax = 4;
  struct Piece {
    std::uint64_t offset = 0;
    std::uint16_t size = 0;
    std::uint8_t lane = 0;  // from kLanes on: samples of the classes
  };
  enum class State : std::uint8_t { kResolved, kInFlight };

  Time at{};
  std::uint16_t size = 0;   // of the datagram
  std::uint16_t probe = 0;  // it tries this size
  State state = State::kResolved;
  bool elicits_ack = false;
  std::uint8_t pieces = 0;
  std::uint8_t skip_lane = 0xFF;  // 0xFF: no SKIP
  std::uint64_t skip_to = 0;
  std::array<Piece, kPiecesMax> piece{};
};

// Hears what became of the packets.
class PacketObserver : public core::Interface {
 public:
  virtual void on_packet_acked(const SentPacket& packet) = 0;
  virtual void on_packet_lost(const SentPacket& packet) = 0;
};

class SentPackets {
 public:
  static constexpr std::uint64_t kInFlightMax = 1 << 15;

  [[nodiscard]] std::uint64_t next() const { return next_; }
  [[nodiscard]] bool full() const { return next_ - first_ >= kInFlightMax; }
  // Fill it in, then say sent(); its number is next() before the call.
  SentPacket& add();
  void sent(SentPacket& packet);

  struct AckResult {
    bool valid = false;  // false: it acknowledges what was never sent
    bool any_new = false;
    std::uint64_t bytes_acked = 0;
    std::uint32_t packets_acked = 0;
    std::uint32_t packets_lost = 0;
    Time newest_sent{};  // of the newest packet it is about, when that is acknowledged now
    bool newest_is_new = false;
    std::uint64_t newest = 0;
  };
  AckResult on_ack(Time now, const Ack& ack, const RttEstimator& rtt, PacketObserver& observer);
  // When the oldest packet that only time can declare lost is lost; kNever: none.
  [[nodiscard]] Time loss_time() const { return loss_time_; }
  AckResult detect_lost(Time now, const RttEstimator& rtt, PacketObserver& observer);

  [[nodiscard]] std::uint64_t bytes_in_flight() const { return bytes_in_flight_; }
  // When the last packet was sent that wants an acknowledgement, and there is none; else kNever.
  [[nodiscard]] Time last_eliciting() const {
    return eliciting_in_flight_ == 0 ? kNever : last_eliciting_;
  }
  // What the oldest packet that is in flight carried is to be sent again; it stays in flight.
  [[nodiscard]] const SentPacket* oldest_in_flight() const;
  // Nothing that is in flight will be acknowledged any more.
  void forget_all(PacketObserver& observer);

 private:
  [[nodiscard]] SentPacket& at(std::uint64_t number) { return ring_[number & (ring_.size() - 1)]; }
  void resolve(SentPacket& packet);
  void skip_resolved();
  void find_lost(Time now, const RttEstimator& rtt, PacketObserver& observer, AckResult& result);

  std::vector<SentPacket> ring_;  // a power of two
  std::uint64_t first_ = 0;       // all before are resolved
  std::uint64_t next_ = 0;
  std::uint64_t largest_acked_ = 0;  // one above it; 0: none
  std::uint64_t bytes_in_flight_ = 0;
  std::uint64_t eliciting_in_flight_ = 0;
  Time last_eliciting_{};
  Time loss_time_ = kNever;
};

}  // namespace tims::link
