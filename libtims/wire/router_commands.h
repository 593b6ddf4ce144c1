// Commands between a TCP client and its router: messages with dest = src = 0 (specification,
// section 3.2). The same numbers mean something else between mailboxes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "tims/address.h"

namespace tims::wire::router_command {

// Ignored by the original. With a body of kWidthsSize bytes, and where addresses are not divided
// into four times 8 bits, our router answers kAddressWidths, before it answers what comes later.
inline constexpr std::int8_t kLogin = 10;
inline constexpr std::int8_t kAddressWidths = -10;
inline constexpr std::int8_t kMailboxInit = 11;
inline constexpr std::int8_t kMailboxDelete = 12;
inline constexpr std::int8_t kMailboxInitWithReply = 13;
inline constexpr std::int8_t kMailboxDeleteWithReply = 14;
inline constexpr std::int8_t kMailboxPurge = 15;
inline constexpr std::int8_t kLifesign = 17;  // router to client; answered with type::kOk
inline constexpr std::int8_t kEnableWatchdog = 18;
inline constexpr std::int8_t kDisableWatchdog = 19;

// The body of kAddressWidths: system, class, instance, local.
inline constexpr std::size_t kWidthsSize = 4;

constexpr std::array<std::byte, kWidthsSize> encode_widths(const AddressWidths& widths) {
  return {std::byte{widths.system}, std::byte{widths.class_id}, std::byte{widths.instance},
          std::byte{widths.local}};
}

// Nothing when they are no widths.
constexpr std::optional<AddressWidths> decode_widths(std::span<const std::byte> body) {
  if (body.size() != kWidthsSize) return std::nullopt;
  const auto bits = [&](std::size_t i) { return std::to_integer<std::uint8_t>(body[i]); };
  const AddressWidths widths{bits(0), bits(1), bits(2), bits(3)};
  if (!widths.valid()) return std::nullopt;
  return widths;
}

}  // namespace tims::wire::router_command
