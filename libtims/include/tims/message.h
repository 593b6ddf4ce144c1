// The 16 bytes in front of every message, as a value in native byte order, and a view of a whole
// message. The bytes themselves: libtims/wire/header.h.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "tims/address.h"

namespace tims {

inline constexpr std::size_t kHeaderSize = 16;
inline constexpr std::uint32_t kMessageMaxDefault = 16U << 20;  // bytes, header included

// Bits of the flags byte (specification, section 1.2; STREAM and TRACE are ours).
namespace flag {
inline constexpr std::uint8_t kHeaderLittleEndian = 0x01;
inline constexpr std::uint8_t kBodyLittleEndian = 0x02;
inline constexpr std::uint8_t kStream = 0x10;  // sample of a continuous stream
inline constexpr std::uint8_t kTrace = 0x20;   // asks every router on the way for a hop record
// Whoever finds that nobody owns the destination answers NOT_AVAILABLE, also when this is no
// command: so a producer learns that a listener has gone.
inline constexpr std::uint8_t kTellIfGone = 0x40;
// The sender of a command takes words behind an ERROR: why it is refused. Programs of the original
// have no room for them.
inline constexpr std::uint8_t kTellWhy = 0x80;
// What a native program sets: the order of its own machine for header and body.
inline constexpr std::uint8_t kNativeOrder =
    std::endian::native == std::endian::little ? kHeaderLittleEndian | kBodyLittleEndian : 0;
}  // namespace flag

// Message types with a meaning for the framework (specification, section 1.3).
// Type numbers are signed bytes: > 0 commands, 0 success, < 0 replies and data.
namespace type {
inline constexpr std::int8_t kOk = 0;
inline constexpr std::int8_t kError = -1;
inline constexpr std::int8_t kTimeout = -2;
inline constexpr std::int8_t kNotAvailable = -3;
inline constexpr std::int8_t kEnabled = -4;
inline constexpr std::int8_t kDisabled = -5;
inline constexpr std::int8_t kData = -6;
inline constexpr std::int8_t kContData = -7;
inline constexpr std::int8_t kParam = -9;
inline constexpr std::int8_t kOn = 1;
inline constexpr std::int8_t kOff = 2;
inline constexpr std::int8_t kGetStatus = 3;
inline constexpr std::int8_t kGetData = 4;
inline constexpr std::int8_t kGetContData = 6;
inline constexpr std::int8_t kStopContData = 7;
inline constexpr std::int8_t kGetNextData = 8;
inline constexpr std::int8_t kGetParam = 9;
inline constexpr std::int8_t kSetParam = 10;
// Of our own runtime: programs of the original answer ERROR.
inline constexpr std::int8_t kGetParamEffects = 14;
inline constexpr std::int8_t kGetRuntime = 15;
inline constexpr std::int8_t kGetListeners = 16;
inline constexpr std::int8_t kParamEffects = -14;
inline constexpr std::int8_t kRuntime = -15;
inline constexpr std::int8_t kListeners = -16;
// Router administration: JSON in the body, to dest = src = 0 or to a router's own address.
inline constexpr std::int8_t kAdminRequest = 64;
inline constexpr std::int8_t kAdminReply = -64;
// What a router says to the sender of a message with flag::kTrace: JSON in the body.
inline constexpr std::int8_t kHopRecord = -65;
}  // namespace type

struct Header {
  std::uint8_t flags = flag::kNativeOrder;
  std::int8_t type = 0;
  std::uint8_t priority = 0;  // higher number = more important
  std::uint8_t seq_nr = 0;    // echoed by replies
  Address dest{};
  Address src{};
  std::uint32_t length = kHeaderSize;  // bytes, header included

  [[nodiscard]] constexpr std::endian body_order() const {
    return (flags & flag::kBodyLittleEndian) != 0 ? std::endian::little : std::endian::big;
  }
  [[nodiscard]] constexpr std::uint32_t body_size() const {
    return length - static_cast<std::uint32_t>(kHeaderSize);
  }
  bool operator==(const Header&) const = default;
};

// A message that lies somewhere else. `body` is as long as the header says.
struct MessageView {
  Header header;
  std::span<const std::byte> body;
};

}  // namespace tims
