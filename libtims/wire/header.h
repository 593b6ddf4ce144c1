// The 16 header bytes in all four combinations of byte orders. No other module knows this layout.
//
//   0 flags u8 | 1 type i8 | 2 priority u8 | 3 seq_nr u8 | 4 dest u32 | 8 src u32 | 12 length u32
//
// Bit 0 of flags is the byte order of dest, src and length; bit 1 is the order of the body, which
// is forwarded unchanged (specification, section 1).
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "tims/message.h"

namespace tims::wire {

using HeaderBytes = std::span<std::byte, kHeaderSize>;
using ConstHeaderBytes = std::span<const std::byte, kHeaderSize>;

// Any 16 bytes decode to a header; the length is not checked (see check_length). The 32-bit fields
// are returned in native order, and flag bit 0 as it was on the wire.
Header decode_header(ConstHeaderBytes bytes);

// Writes dest, src and length in `order` and sets flag bit 0 accordingly; all other flags are kept.
void encode_header(const Header& header, HeaderBytes bytes,
                   std::endian order = std::endian::native);

enum class LengthVerdict { kOk, kTooShort, kTooLong };
constexpr LengthVerdict check_length(std::uint32_t length, std::uint32_t length_max) {
  if (length < kHeaderSize) return LengthVerdict::kTooShort;
  return length > length_max ? LengthVerdict::kTooLong : LengthVerdict::kOk;
}

// The reply convention (section 1.5): addresses swapped, priority and seq_nr kept.
constexpr Header reply_to(const Header& request, std::int8_t type, std::uint32_t body_size = 0) {
  return {.flags = flag::kNativeOrder,
          .type = type,
          .priority = request.priority,
          .seq_nr = request.seq_nr,
          .dest = request.src,
          .src = request.dest,
          .length = static_cast<std::uint32_t>(kHeaderSize) + body_size};
}

// --- hot path: access in place

// A 32-bit field in the given byte order.
struct HeaderWord {
  static std::uint32_t in(std::endian order, std::uint32_t word) {
    return order == std::endian::native ? word : __builtin_bswap32(word);
  }
  static std::uint32_t load(const std::byte* from, std::endian order) {
    std::uint32_t word = 0;
    std::memcpy(&word, from, sizeof word);
    return in(order, word);
  }
  static void store(std::byte* to, std::uint32_t word, std::endian order) {
    word = in(order, word);
    std::memcpy(to, &word, sizeof word);
  }
};

inline Header decode_header(ConstHeaderBytes bytes) {
  const auto flags = std::to_integer<std::uint8_t>(bytes[0]);
  const std::endian order =
      (flags & flag::kHeaderLittleEndian) != 0 ? std::endian::little : std::endian::big;
  return {.flags = flags,
          .type = static_cast<std::int8_t>(bytes[1]),
          .priority = std::to_integer<std::uint8_t>(bytes[2]),
          .seq_nr = std::to_integer<std::uint8_t>(bytes[3]),
          .dest = Address(HeaderWord::load(&bytes[4], order)),
          .src = Address(HeaderWord::load(&bytes[8], order)),
          .length = HeaderWord::load(&bytes[12], order)};
}

inline void encode_header(const Header& header, HeaderBytes bytes, std::endian order) {
  const unsigned order_bit = order == std::endian::little ? flag::kHeaderLittleEndian : 0U;
  bytes[0] = static_cast<std::byte>((header.flags & ~flag::kHeaderLittleEndian) | order_bit);
  bytes[1] = static_cast<std::byte>(header.type);
  bytes[2] = static_cast<std::byte>(header.priority);
  bytes[3] = static_cast<std::byte>(header.seq_nr);
  HeaderWord::store(&bytes[4], header.dest.raw(), order);
  HeaderWord::store(&bytes[8], header.src.raw(), order);
  HeaderWord::store(&bytes[12], header.length, order);
}

}  // namespace tims::wire
