// How many bytes may be on their way: the window that keeps a link busy and its queues short.
//
// The rate is found by delay. What the smallest round trip of a round has above that of the path
// without us is the queue that we make. The window grows while that is below a target of 1.5
// milliseconds and shrinks in proportion above it, as in LEDBAT (RFC 6817) with a target small
// enough for commands. As in LEDBAT++ (draft-irtf-iccrg-ledbat-plus-plus) we leave the queue for
// two rounds every now and then, and see the path without us: the delay that is left is not ours,
// but that of others, or of a radio that hands on in bursts, and nothing to shrink for. So several
// senders each make their own queue and get equal shares, as in TCP Vegas (Brakmo and
// Peterson 1995), and none takes the others' queue for the path.
//
// Loss alone says little on Wi-Fi, and up to an eighth of a round is taken as the medium's. Beyond
// that in two rounds running, the window falls to what came through (as BBRv2 bounds its window by
// what was delivered).
#pragma once

#include <array>
#include <cstdint>

#include "tims/time.h"

namespace tims::link {

class Congestion {
 public:
  explicit Congestion(std::size_t datagram) : datagram_(datagram), window_(kInitial * datagram) {}

  void set_datagram(std::size_t datagram) { datagram_ = datagram; }

  // What an acknowledgement told. `in_flight`: bytes before it came.
  struct Feedback {
    Duration rtt{};  // zero: no new sample
    std::uint64_t bytes_acked = 0;
    std::uint32_t packets_acked = 0;
    std::uint32_t packets_lost = 0;
    std::uint64_t newest_acked = 0;  // packet number
    std::uint64_t next_packet = 0;   // number of the next one to be sent
    std::uint64_t in_flight = 0;
  };
  void on_feedback(Time now, const Feedback& feedback);
  // Nothing was acknowledged for long: begin again.
  void on_silence();

  [[nodiscard]] std::uint64_t window() const { return window_; }
  [[nodiscard]] bool may_send(std::uint64_t in_flight) const { return in_flight < window_; }
  // More than the window allows, for what is urgent.
  [[nodiscard]] std::uint64_t urgent_window() const { return window_ + kUrgent * datagram_; }

  // Bytes a second that a window takes.
  [[nodiscard]] std::uint64_t rate(Duration smoothed_rtt) const;
  // Bytes a second to be sent at most, so that a window goes out evenly.
  [[nodiscard]] std::uint64_t pacing_rate(Duration smoothed_rtt) const;

  [[nodiscard]] Duration queue_delay() const { return queue_delay_; }
  [[nodiscard]] Duration base_rtt() const;

 private:
  static constexpr std::size_t kInitial = 16;  // datagrams
  static constexpr std::size_t kMin = 4;
  static constexpr std::size_t kUrgent = 10;
  static constexpr Duration kTarget = std::chrono::microseconds(1500);
  static constexpr Duration kBaseSpan = std::chrono::seconds(5);  // of each of two halves
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
  Duration queue_delay_{};  // that we make
  Duration last_rtt_{};
  Duration jitter_{};  // between one round trip and the next (RFC 3550, 6.4.1)
  Duration others_{};  // what is left of the delay when we have left the queue

  std::array<Duration, 2> base_{Duration::max(), Duration::max()};  // this span's, the last one's
  Time base_since_{};

  std::uint64_t round_end_ = 0;  // the round ends when a packet from here on is acknowledged
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
  double rate_before_ = 0;  // bytes a second that came through before we left
  Duration rtt_before_{};
  std::uint64_t window_after_ = 0;  // to come back to
};

}  // namespace tims::link
