// Where a datagram comes from or goes to.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace tims::link {

// Ways to move a datagram.
enum class PathKind : std::uint8_t { kUdp, kDds };
inline constexpr std::size_t kPathKinds = 2;
std::string_view name(PathKind kind);  // "udp", "dds"

// The first bytes of a DDS participant's GUID, which no other participant has.
using DdsParticipant = std::array<std::uint8_t, 12>;

// IPv4 addresses stand in their IPv6 form ::ffff:a.b.c.d, so that all are one kind of key. Of a DDS
// participant, `ip` begins with the GUID prefix.
struct NetAddress {
  std::array<std::uint8_t, 16> ip{};  // network order
  std::uint16_t port = 0;             // 0: no address
  std::uint32_t scope = 0;            // interface of a link-local IPv6 address
  PathKind kind = PathKind::kUdp;

  explicit operator bool() const { return port != 0; }
  [[nodiscard]] bool is_v4() const;
  // "10.9.1.1:2010", "[fe80::1%3]:2010", "dds:010f6e1f0a00000001000000"
  [[nodiscard]] std::string to_string() const;
  [[nodiscard]] DdsParticipant participant() const;  // of a DDS address

  static NetAddress v4(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d,
                       std::uint16_t port);
  static NetAddress dds(const DdsParticipant& participant);

  auto operator<=>(const NetAddress&) const = default;
};

}  // namespace tims::link
