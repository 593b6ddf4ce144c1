// A network of the internet: "10.9.0.0/16", "fd00::/8"; without a length, one address.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace tims::base {

class IpNetwork {
 public:
  // Numeric forms without a scope ("%eth0"). An IPv4 network is also that of its mapped addresses
  // (::ffff:a.b.c.d). Empty: no such network.
  static std::optional<IpNetwork> parse(std::string_view text);

  // True when each address of the other one is in this network.
  [[nodiscard]] bool contains(const IpNetwork& other) const;

 private:
  std::array<std::uint8_t, 16> address_{};  // IPv4 as ::ffff:a.b.c.d
  unsigned bits_ = 0;
};

}  // namespace tims::base
