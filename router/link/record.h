// A message as it stands in a lane: four bytes of the link's own, then the message.
//
//   0 hops u8 | 1 flags u8 (0) | 2 waited u16: for traced messages, time in the sender's queue
//
// What the routers say to each other (control.h) stands in its lane in the same way.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "router/core/message.h"
#include "router/core/statistics.h"
#include "router/link/frame.h"
#include "tims/message.h"
#include "tims/time.h"

namespace tims::link {

inline constexpr std::size_t kRecordPrefix = 4;
inline constexpr std::size_t kRecordHead = kRecordPrefix + kHeaderSize;
inline constexpr Duration kWaitedUnit = std::chrono::microseconds(100);

constexpr std::size_t record_size(std::size_t message) { return kRecordPrefix + message; }

struct RecordPrefix {
  std::uint8_t hops = 0;
  Duration waited{};

  [[nodiscard]] std::array<std::byte, kRecordPrefix> encoded() const {
    const auto units =
        static_cast<std::uint16_t>(std::clamp<std::int64_t>(waited / kWaitedUnit, 0, 0xFFFF));
    return {std::byte{hops}, std::byte{0}, static_cast<std::byte>(units & 0xFF),
            static_cast<std::byte>(units >> 8)};
  }
  static RecordPrefix decode(std::span<const std::byte> bytes) {
    const auto low = std::to_integer<std::uint16_t>(bytes[2]);
    const auto high = std::to_integer<std::uint16_t>(bytes[3]);
    return {std::to_integer<std::uint8_t>(bytes[0]), (low | high << 8) * kWaitedUnit};
  }
};

// Takes what a link has brought.
class Arrivals {
 public:
  virtual ~Arrivals() = default;
  // The bytes, which may be changed, stay where they are until the turn is flushed.
  virtual void on_message(Time now, const RecordPrefix& prefix, core::Message& message) = 0;
  virtual void on_control(Time now, const core::Message& message) = 0;
  virtual void on_frame(Time now, const KeepAlive& frame) = 0;
  virtual void on_frame(Time now, const ChallengeFrame& frame) = 0;
  virtual void on_frame(Time now, const ResponseFrame& frame) = 0;
  virtual void on_frame(Time now, const CloseFrame& frame) = 0;

 protected:
  Arrivals() = default;
  Arrivals(const Arrivals&) = default;
  Arrivals& operator=(const Arrivals&) = default;
};

// Hears of messages that were taken and will not arrive.
class Losses {
 public:
  virtual ~Losses() = default;
  virtual void on_lost(Time now, const Header& header, core::Outcome why) = 0;

 protected:
  Losses() = default;
  Losses(const Losses&) = default;
  Losses& operator=(const Losses&) = default;
};

}  // namespace tims::link
