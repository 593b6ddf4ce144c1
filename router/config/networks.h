// A list of networks of a configuration: "loopback, 10.9.0.0/16, fd00::/8".
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "tims/result.h"

namespace tims::config {

class Networks {
 public:
  // kInvalidArgument: the detail names the item and the valid forms. An empty list contains
  // nothing.
  static Result<Networks> parse(std::string_view list);

  // `endpoint`: a numeric address with a port, "10.9.1.7:40312" or "[fd00::1]:40312".
  [[nodiscard]] bool contains(std::string_view endpoint) const;

 private:
  struct Network {
    std::array<std::uint8_t, 16> address{};  // IPv4 as ::ffff:a.b.c.d
    unsigned bits = 0;
  };
  static Result<Network> parse_one(const std::string& text);

  std::vector<Network> networks_;
};

}  // namespace tims::config
