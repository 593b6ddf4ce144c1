// Where a datagram comes from or goes to.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace tims::link {

// IPv4 addresses stand in their IPv6 form ::ffff:a.b.c.d, so that both are one kind of key.
struct NetAddress {
  std::array<std::uint8_t, 16> ip{};  // network order
  std::uint16_t port = 0;             // 0: no address
  std::uint32_t scope = 0;            // interface of a link-local IPv6 address

  explicit operator bool() const { return port != 0; }
  [[nodiscard]] bool is_v4() const;
  [[nodiscard]] std::string to_string() const;  // "10.9.1.1:2010", "[fe80::1%3]:2010"

  static NetAddress v4(std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d,
                       std::uint16_t port);

  auto operator<=>(const NetAddress&) const = default;
};

}  // namespace tims::link
