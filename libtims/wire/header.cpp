#include "wire/header.h"

namespace tims::wire {
namespace {

// Offsets of the words; byte 0 says in which order they are.
constexpr std::size_t kDest = 4;
constexpr std::size_t kSrc = 8;
constexpr std::size_t kLength = 12;

constexpr std::uint32_t byte_at(ConstHeaderBytes bytes, std::size_t i) {
  return std::to_integer<std::uint32_t>(bytes[i]);
}

// Compilers make one load, and a byte swap where needed, of this.
constexpr std::uint32_t load(ConstHeaderBytes bytes, std::size_t at, std::endian order) {
  const std::uint32_t little = byte_at(bytes, at) | byte_at(bytes, at + 1) << 8 |
                               byte_at(bytes, at + 2) << 16 | byte_at(bytes, at + 3) << 24;
  const std::uint32_t big = byte_at(bytes, at) << 24 | byte_at(bytes, at + 1) << 16 |
                            byte_at(bytes, at + 2) << 8 | byte_at(bytes, at + 3);
  return order == std::endian::little ? little : big;
}

constexpr void store(HeaderBytes bytes, std::size_t at, std::uint32_t value, std::endian order) {
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t shift = 8 * (order == std::endian::little ? i : 3 - i);
    bytes[at + i] = static_cast<std::byte>(value >> shift);
  }
}

}  // namespace

Header decode_header(ConstHeaderBytes bytes) {
  const auto flags = std::to_integer<std::uint8_t>(bytes[0]);
  const std::endian order =
      (flags & flag::kHeaderLittleEndian) != 0 ? std::endian::little : std::endian::big;
  return {.flags = flags,
          .type = static_cast<std::int8_t>(bytes[1]),
          .priority = std::to_integer<std::uint8_t>(bytes[2]),
          .seq_nr = std::to_integer<std::uint8_t>(bytes[3]),
          .dest = Address(load(bytes, kDest, order)),
          .src = Address(load(bytes, kSrc, order)),
          .length = load(bytes, kLength, order)};
}

void encode_header(const Header& header, HeaderBytes bytes, std::endian order) {
  const unsigned order_bit = order == std::endian::little ? flag::kHeaderLittleEndian : 0U;
  bytes[0] = static_cast<std::byte>((header.flags & ~flag::kHeaderLittleEndian) | order_bit);
  bytes[1] = static_cast<std::byte>(header.type);
  bytes[2] = static_cast<std::byte>(header.priority);
  bytes[3] = static_cast<std::byte>(header.seq_nr);
  store(bytes, kDest, header.dest.raw(), order);
  store(bytes, kSrc, header.src.raw(), order);
  store(bytes, kLength, header.length, order);
}

}  // namespace tims::wire
