// Packets by number: received ones (PacketWindow), and sent ones whose fate is unknown
// (SentPackets).
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

// Numbers of received packets: detects replays and provides the ranges to acknowledge. A packet
// that was seen and not kept, for lack of memory, is a replay when it comes again, although it is
// not acknowledged: its contents are sent again under another number. Remembers the newest kWindow
// numbers; older ones count as seen.
class PacketWindow {
 public:
  static constexpr std::uint64_t kWindow = 4096;

  // The full number for the 32 bits on the wire: the one nearest to the next expected number.
  [[nodiscard]] std::uint64_t expand(std::uint32_t wire) const;

  [[nodiscard]] bool is_new(std::uint64_t packet) const;
  // `kept`: its contents were stored, so it is acknowledged. Precondition: it is new.
  void add(std::uint64_t packet, bool kept = true);

  [[nodiscard]] std::uint64_t next() const { return next_; }  // one above the newest
  // All numbers below count as seen, and none of them is acknowledged. Precondition: it is new.
  void continue_at(std::uint64_t next) {
    next_ = next;
    seen_.fill(~std::uint64_t{0});
  }
  // The newest ranges; none before the first packet arrives.
  void fill(Ack& ack) const;

 private:
  using Bits = std::array<std::uint64_t, kWindow / 64>;  // bit n % kWindow: packet n

  [[nodiscard]] std::uint64_t below(std::uint64_t packet, bool kept) const;

  std::uint64_t next_ = 0;
  Bits seen_{};
  Bits kept_{};
};

// Sent packets with their contents, until they are acknowledged or declared lost. Loss detection
// follows RFC 9002, section 6.1: three packets sent later have arrived, or one sent later and
// enough time has passed.
struct SentPacket {
  static constexpr std::size_t kPiecesMax = 4;
  struct Piece {
    std::uint64_t offset = 0;
    std::uint16_t size = 0;
    std::uint8_t lane = 0;  // from kLanes on: samples of the classes
  };
  enum class State : std::uint8_t { kResolved, kInFlight };

  Time at{};
  std::uint16_t size = 0;   // size of the datagram
  std::uint16_t probe = 0;  // the size this packet probes
  State state = State::kResolved;
  bool elicits_ack = false;
  std::uint8_t pieces = 0;
  std::uint8_t skip_lane = 0xFF;  // 0xFF: no SKIP
  std::uint64_t skip_to = 0;
  std::array<Piece, kPiecesMax> piece{};
};

// Receives the fate of packets.
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
  // Numbers below were used; their fate is of no interest. Precondition: it is new.
  void continue_at(std::uint64_t next) { first_ = next_ = next; }
  // Fill in the entry, then call sent(); its number is next() before the call.
  SentPacket& add();
  void sent(SentPacket& packet);

  struct AckResult {
    // False: it acknowledges packets that were never sent, or its ranges do not descend.
    bool valid = false;
    bool any_new = false;
    std::uint64_t bytes_acked = 0;
    std::uint32_t packets_acked = 0;
    std::uint32_t packets_lost = 0;
    Time newest_sent{};  // send time of the newest packet covered, when it is newly acknowledged
    bool newest_is_new = false;
    std::uint64_t newest = 0;
  };
  AckResult on_ack(Time now, const Ack& ack, const RttEstimator& rtt, PacketObserver& observer);
  // When the oldest packet that only time can declare lost will be lost; kNever: none.
  [[nodiscard]] Time loss_time() const { return loss_time_; }
  AckResult detect_lost(Time now, const RttEstimator& rtt, PacketObserver& observer);

  [[nodiscard]] std::uint64_t bytes_in_flight() const { return bytes_in_flight_; }
  // When the last unacknowledged ack-eliciting packet was sent; kNever: none.
  [[nodiscard]] Time last_eliciting() const {
    return eliciting_in_flight_ == 0 ? kNever : last_eliciting_;
  }
  // The oldest packet in flight, whose contents are to be sent again; it stays in flight.
  [[nodiscard]] const SentPacket* oldest_in_flight() const;
  // No packet in flight will be acknowledged any more.
  void forget_all(PacketObserver& observer);

 private:
  [[nodiscard]] SentPacket& at(std::uint64_t number) { return ring_[number & (ring_.size() - 1)]; }
  void resolve(SentPacket& packet);
  void skip_resolved();
  void find_lost(Time now, const RttEstimator& rtt, PacketObserver& observer, AckResult& result);

  std::vector<SentPacket> ring_;  // a power of two
  std::uint64_t first_ = 0;       // all earlier packets are resolved
  std::uint64_t next_ = 0;
  std::uint64_t largest_acked_ = 0;  // largest acknowledged number plus one; 0: none
  std::uint64_t bytes_in_flight_ = 0;
  std::uint64_t eliciting_in_flight_ = 0;
  Time last_eliciting_{};
  Time loss_time_ = kNever;
};

}  // namespace tims::link
