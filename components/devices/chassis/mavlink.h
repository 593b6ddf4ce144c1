// MAVLink 1 and 2: the protocol of autopilots (ArduPilot, PX4) and ground stations.
//
// A packet of version 2 is FD, length, incompatibility flags, compatibility flags, sequence,
// system, component, message (3 bytes), payload, CRC; of version 1 FE, length, sequence, system,
// component, message, payload, CRC; all little-endian. The CRC (X.25) covers everything after the
// first byte, followed by an extra byte that identifies the layout of the message. Version 2 omits
// trailing zeros of the payload.
//
// Source: mavlink.io, guide and common message set.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "rack/devices/stream_buffer.h"

namespace rack::device::mavlink {

enum class Message : std::uint32_t {
  kHeartbeat = 0,
  kSystemStatus = 1,
  kGpsRaw = 24,
  kAttitude = 30,
  kLocalPosition = 32,
  kCommand = 76,
  kCommandAck = 77,
  kSetPositionTarget = 84,
  kOdometry = 331,
};

// Length of the complete payload, and the extra byte of the CRC. Empty for messages that RACK does
// not use.
struct Layout {
  std::uint8_t size;
  std::uint8_t crc_extra;
};
std::optional<Layout> layout_of(std::uint32_t message);

struct Packet {
  static constexpr std::size_t kPayloadMax = 255;

  Message message{};
  std::uint8_t system = 0;
  std::uint8_t component = 0;
  // Has the length of the layout; omitted bytes are 0.
  std::array<std::byte, kPayloadMax> payload{};
  Time began{};

  template <typename Number>
  [[nodiscard]] Number number(std::size_t at) const {
    return little_endian<Number>(payload, at);
  }
  [[nodiscard]] double real(std::size_t at) const;
};

class Packets {
 public:
  void add(const Arrival& arrival) { buffer_.add(arrival); }
  // Returns false if there is no complete packet yet. Skips unknown messages.
  bool next(Packet& packet);
  void clear() { buffer_.clear(); }
  [[nodiscard]] std::uint64_t broken() const { return broken_; }

 private:
  static constexpr std::size_t kSizeMax = 10 + 255 + 2 + 13;

  StreamBuffer buffer_{8 * kSizeMax};
  std::uint64_t broken_ = 0;
};

std::uint16_t crc(std::span<const std::byte> bytes, std::uint8_t extra);

// Writes a packet of version 2 without allocating memory.
class Writer {
 public:
  Writer(Message message, std::uint8_t sequence, std::uint8_t system, std::uint8_t component);

  template <typename Number>
  Writer& put(Number number) {
    for (std::size_t i = 0; i < sizeof number; ++i)
      bytes_[size_++] = static_cast<std::byte>(
          static_cast<std::uint64_t>(static_cast<std::make_unsigned_t<Number>>(number)) >> 8 * i);
    return *this;
  }
  Writer& put_real(double value);
  // The whole packet; nothing more can be put.
  std::span<const std::byte> finish();

 private:
  std::array<std::byte, 10 + Packet::kPayloadMax + 2> bytes_{};
  std::size_t size_ = 10;
  std::uint8_t extra_;
};

}  // namespace rack::device::mavlink
