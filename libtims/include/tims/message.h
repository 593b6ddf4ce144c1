// The 16 header bytes of every message, as a value in native byte order, and a view of a whole
// message. The byte layout is defined in libtims/wire/header.h.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "tims/address.h"

namespace tims {

inline constexpr std::size_t kHeaderSize = 16;
inline constexpr std::uint32_t kMessageMaxDefault = 16U << 20;  // bytes, header included

// Bits of the flags byte (specification, section 1.2). kStream and the following bits extend the
// original protocol.
namespace flag {
inline constexpr std::uint8_t kHeaderLittleEndian = 0x01;
inline constexpr std::uint8_t kBodyLittleEndian = 0x02;
inline constexpr std::uint8_t kStream = 0x10;  // sample of a continuous stream
inline constexpr std::uint8_t kTrace = 0x20;   // asks every router on the path for a hop record
// A router that finds no mailbox with the destination address answers NOT_AVAILABLE, also when the
// message is not a command. A producer learns in this manner that a listener is gone.
inline constexpr std::uint8_t kReportIfGone = 0x40;
// The sender of a command accepts a text after an ERROR reply: the reason of the refusal. Programs
// of the original RACK do not expect a body there.
inline constexpr std::uint8_t kReportReason = 0x80;
// Flags of a native program: header and body are in the byte order of its machine.
inline constexpr std::uint8_t kNativeOrder =
    std::endian::native == std::endian::little ? kHeaderLittleEndian | kBodyLittleEndian : 0;
}  // namespace flag

// Message types with a meaning for the framework (specification, section 1.3). Types are signed
// bytes: > 0 commands, 0 success, < 0 replies and data.
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
// Extensions of this runtime: programs of the original RACK answer ERROR.
inline constexpr std::int8_t kGetDescription = 13;
inline constexpr std::int8_t kGetParamEffects = 14;
inline constexpr std::int8_t kGetRuntime = 15;
inline constexpr std::int8_t kGetListeners =
    16;  // 17 would be a lifesign to the original's C library
inline constexpr std::int8_t kDescription = -13;
inline constexpr std::int8_t kParamEffects = -14;
inline constexpr std::int8_t kRuntime = -15;
inline constexpr std::int8_t kListeners = -16;
// Router administration: JSON in the body, to dest = src = 0 or to a router's own address.
inline constexpr std::int8_t kAdminRequest = 64;
inline constexpr std::int8_t kAdminReply = -64;
// A router's reply to the sender of a message with flag::kTrace: JSON in the body.
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

// A message in memory that belongs to somebody else. `body` is as long as the header states.
struct MessageView {
  Header header;
  std::span<const std::byte> body;
};

}  // namespace tims
