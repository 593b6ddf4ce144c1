// The state of a CAN bus according to the error frames of its controller, and the times at which a
// controller in state bus-off is restarted: after 0.1 s, then after twice the previous pause, at
// most five times a minute. On a bus with a persistent fault, each attempt disturbs the nodes that
// can still communicate.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tims/time.h"

namespace rack::device {

using tims::Duration;
using tims::Time;

class CanBus {
 public:
  struct Counters {
    std::uint64_t bus_off = 0;
    std::uint64_t restarts = 0;
    std::uint64_t no_acknowledge = 0;  // no other node is on the bus, or none at this bit rate
    std::uint64_t lost = 0;            // frames lost because the controller's buffer was full
    std::uint64_t warnings = 0;        // an error counter exceeded 96
    std::uint64_t passive = 0;         // an error counter exceeded 127
    std::uint64_t errors = 0;          // bit, form and checksum errors
    std::uint64_t late = 0;            // frames dropped unsent because their deadline had passed
  };

  explicit CanBus(std::string name) : name_(std::move(name)) {}

  // The interface was opened (again); events before are unknown.
  void on_open(Time now);
  // `id` has the flags of SocketCAN. Returns a message for the log, at most once a second.
  std::optional<std::string> on_error_frame(std::uint32_t id, std::span<const std::byte> bytes,
                                            Time now);
  // A frame was received: the bus works again.
  void on_frame() { off_since_ = next_restart_ = tims::kNever; }
  void on_late(std::size_t frames) { counters_.late += frames; }

  // When the controller must be restarted next.
  [[nodiscard]] Time next_restart() const { return next_restart_; }
  void on_restart(Time now);
  // Why the bus must be closed: it went bus-off too often, or has been off for too long.
  [[nodiscard]] std::optional<std::string> failure(Time now) const;

  [[nodiscard]] bool is_off() const { return off_since_ != tims::kNever; }
  [[nodiscard]] const Counters& counters() const { return counters_; }
  // For example "1 bus-off, 12 errors"; empty if there were no errors.
  [[nodiscard]] std::string summary() const;

 private:
  static constexpr std::size_t kRestartsMax = 5;  // per minute

  void on_bus_off(Time now);
  void plan_restart(Time now);
  std::optional<std::string> report(Time now, std::string text);

  std::string name_;
  Counters counters_;
  Time off_since_ = tims::kNever;
  Time next_restart_ = tims::kNever;
  Duration pause_{};
  std::array<Time, kRestartsMax> restarts_{};  // ring buffer of the most recent restarts
  std::size_t restarted_ = 0;
  bool is_given_up_ = false;
  Time reported_{};
  Time reported_off_{};
};

// A short queue of frames to send. The frame with the lowest identifier is first, as in the
// arbitration of the bus (a standard frame precedes extended frames with the same leading bits).
// Frames whose deadline has passed are dropped.
class CanQueue {
 public:
  struct Frame {
    std::uint32_t id = 0;
    std::uint8_t size = 0;
    std::array<std::byte, 8> bytes{};
    Time deadline{};
  };

  CanQueue() { frames_.reserve(kMost); }

  // Returns false if the queue is full or the frame is longer than 8 bytes.
  bool add(std::uint32_t id, std::span<const std::byte> bytes, Time deadline);
  [[nodiscard]] bool empty() const { return frames_.empty(); }
  [[nodiscard]] const Frame& front() const { return frames_.front(); }
  void pop() { frames_.erase(frames_.begin()); }
  void clear() { frames_.clear(); }
  // Returns the number of frames dropped.
  std::size_t drop_late(Time now);

 private:
  static constexpr std::size_t kMost = 64;

  std::vector<Frame> frames_;
};

}  // namespace rack::device
