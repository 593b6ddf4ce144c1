// What is known of a CAN bus by the error frames of its controller, and when a controller that has
// left the bus (bus-off) is sent back: after 0.1 s, then each time twice as late, and not more
// often than five times a minute, for a bus that is broken stays so, and each attempt disturbs
// those who can still talk.
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
    std::uint64_t no_acknowledge = 0;  // nobody else is on the bus, or at another bit rate
    std::uint64_t lost = 0;            // frames that the controller had no room for
    std::uint64_t warnings = 0;        // its error counters have come above 96
    std::uint64_t passive = 0;         // above 127
    std::uint64_t errors = 0;          // of bits, forms, checksums
    std::uint64_t late = 0;            // frames that were dropped unsent, after the queue's limit
  };

  explicit CanBus(std::string name) : name_(std::move(name)) {}

  // The interface was opened (again): what was missed meanwhile is not known.
  void on_open(Time now);
  // With the flags of SocketCAN. Returns what people should know, at most once a second.
  std::optional<std::string> on_error_frame(std::uint32_t id, std::span<const std::byte> bytes,
                                            Time now);
  // Something has come over the bus: it is there again.
  void on_frame() { off_since_ = next_restart_ = tims::kNever; }
  void on_late(std::size_t frames) { counters_.late += frames; }

  // When the controller is to be sent back to the bus.
  [[nodiscard]] Time next_restart() const { return next_restart_; }
  void on_restart(Time now);
  // Why this bus is given up for now: it was off too often, or is for too long.
  [[nodiscard]] std::optional<std::string> failure(Time now) const;

  [[nodiscard]] bool is_off() const { return off_since_ != tims::kNever; }
  [[nodiscard]] const Counters& counters() const { return counters_; }
  // "1 bus-off, 12 errors"; empty: nothing was wrong.
  [[nodiscard]] std::string summary() const;

 private:
  static constexpr std::size_t kRestartsMax = 5;  // a minute

  void on_bus_off(Time now);
  void plan_restart(Time now);
  std::optional<std::string> say(Time now, std::string text);

  std::string name_;
  Counters counters_;
  Time off_since_ = tims::kNever;
  Time next_restart_ = tims::kNever;
  Duration pause_{};
  std::array<Time, kRestartsMax> restarts_{};  // the last ones
  std::size_t restarted_ = 0;
  bool is_given_up_ = false;
  Time said_{};
  Time said_off_{};
};

// Frames that wait until they can be sent: few, the lower identifier first as on the bus itself
// (a standard one before extended ones that begin alike), and those whose time has passed are
// dropped.
class CanQueue {
 public:
  struct Frame {
    std::uint32_t id = 0;
    std::uint8_t size = 0;
    std::array<std::byte, 8> bytes{};
    Time deadline{};
  };

  CanQueue() { frames_.reserve(kMost); }

  // False: it is full, or the frame is longer than 8 bytes.
  bool add(std::uint32_t id, std::span<const std::byte> bytes, Time deadline);
  [[nodiscard]] bool empty() const { return frames_.empty(); }
  [[nodiscard]] const Frame& front() const { return frames_.front(); }
  void pop() { frames_.erase(frames_.begin()); }
  void clear() { frames_.clear(); }
  // How many.
  std::size_t drop_late(Time now);

 private:
  static constexpr std::size_t kMost = 64;

  std::vector<Frame> frames_;
};

}  // namespace rack::device
