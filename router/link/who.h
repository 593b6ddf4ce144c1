// Who a router is, as bytes: what a HELLO, a WELCOME and an announcement have in common
// (PROTOCOL.md draws it).
#pragma once

#include <cstddef>
#include <cstdint>

#include "router/link/bytes.h"
#include "router/link/identity.h"

namespace tims::link {

inline constexpr std::size_t kWhoBytesMax = 27 + 63;

template <typename Enum>
bool get_enum(ByteReader& in, Enum last, Enum& value) {
  const auto number = in.get<std::uint8_t>();
  value = static_cast<Enum>(number);
  return number <= static_cast<std::uint8_t>(last);
}

void put(ByteWriter& out, const Identity& who);
// False for bytes that are nobody.
bool get(ByteReader& in, Identity& who);

}  // namespace tims::link
