// Number of bytes that may be in flight: the window that keeps a link busy and its queues short.
//
// The rate is controlled by delay. The queueing delay is the smallest round trip of a round minus
// that of the empty path. The window grows while this delay is below a target of 1.5 milliseconds
// and shrinks in proportion above it, as in LEDBAT (RFC 6817) with a target small enough for
// commands. As in LEDBAT++ (draft-irtf-iccrg-ledbat-plus-plus), the sender drains its queue for
// two rounds from time to time to measure the path without its own traffic: the remaining delay
// is caused by others, or by a radio that forwards in bursts, and is no reason to shrink. So
// several senders each build their own queue and get equal shares, as in TCP Vegas (Brakmo and
// Peterson 1995), and none mistakes the queue of the others for the path.
//
// On Wi-Fi, loss is no reliable sign of congestion: up to an eighth of a round is attributed to
// the medium. Beyond that in two consecutive rounds, the window falls to the amount delivered (as
// BBRv2 bounds its window by what was delivered).
#pragma once

#include <array>
#include <cstdint>

#include "tims/time.h"

namespace tims::link {

class Congestion {
 public:
  explicit Congestion(std::size_t datagram) : datagram_(datagram), window_(kInitial * datagram) {}

  void set_datagram(std::size_t datagram) { datagram_ = datagram; }

  // The contents of an acknowledgement. `in_flight`: bytes before it arrived.
  struct Feedback {
    Duration rtt{};  // zero: no new sample
    std::uint64_t bytes_acked = 0;
    std::uint32_t packets_acked = 0;
    std::uint32_t packets_lost = 0;
    std::uint64_t newest_acked = 0;  // packet number
    std::uint64_t next_packet = 0;   // number of the next packet to be sent
    std::uint64_t in_flight = 0;
  };
  void on_feedback(Time now, const Feedback& feedback);
  // Nothing was acknowledged for a long time: restart.
  void on_silence();

  [[nodiscard]] std::uint64_t window() const { return window_; }
  [[nodiscard]] bool may_send(std::uint64_t in_flight) const { return in_flight < window_; }
  // The larger window for urgent messages.
  [[nodiscard]] std::uint64_t urgent_window() const { return window_ + kUrgent * datagram_; }

  // Bytes per second that one window per round trip amounts to.
  [[nodiscard]] std::uint64_t rate(Duration smoothed_rtt) const;
  // Maximum sending rate in bytes per second, so that a window is spread evenly.
  [[nodiscard]] std::uint64_t pacing_rate(Duration smoothed_rtt) const;

  [[nodiscard]] Duration queue_delay() const { return queue_delay_; }
  [[nodiscard]] Duration base_rtt() const;

 private:
  static constexpr std::size_t kInitial = 16;  // datagrams
  static constexpr std::size_t kMin = 4;
  static constexpr std::size_t kUrgent = 10;
  static constexpr Duration kTarget = std::chrono::microseconds(1500);
  static constexpr Duration kBaseSpan = std::chrono::seconds(5);  // length of each of two halves
  static constexpr std::uint64_t kWindowMax = 64U << 20;

  void add_sample(Time now, Duration rtt);
  void end_round(Time now, const Feedback& feedback);
  void leave_queue(Time now, bool overshot);
  void come_back(Time now, Duration rtt);
  [[nodiscard]] double round_rate(Time now) const;
  void adapt_to_delay();
  [[nodiscard]] Duration target() const;
  void adapt_to_loss();
  void begin_round(const Feedback& feedback);
  [[nodiscard]] std::uint64_t at_least_min(std::uint64_t window) const;

  std::size_t datagram_;
  std::uint64_t window_;
  bool slow_start_ = true;
  Duration queue_delay_{};  // caused by this sender
  Duration last_rtt_{};
  Duration jitter_{};  // difference between consecutive round trips (RFC 3550, 6.4.1)
  Duration others_{};  // delay that remains while this sender's queue is drained

  // Minimum of this span and of the previous one.
  std::array<Duration, 2> base_{Duration::max(), Duration::max()};
  Time base_since_{};

  std::uint64_t round_end_ = 0;  // the round ends when a packet from this number on is acknowledged
  Duration round_rtt_ = Duration::max();  // the smallest, and the largest
  Duration round_rtt_max_{};
  Time round_since_{};
  std::uint64_t round_acked_ = 0;
  std::uint32_t round_packets_ = 0;
  std::uint32_t round_lost_ = 0;
  bool round_limited_ = false;  // the window was full at some time
  bool lossy_before_ = false;

  Time next_leave_{};
  int rounds_away_ = 0;
  double rate_before_ = 0;  // bytes per second delivered before draining
  Duration rtt_before_{};
  std::uint64_t window_after_ = 0;  // window to return to
};

}  // namespace tims::link
