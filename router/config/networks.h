// A list of networks of a configuration: "loopback, 10.9.0.0/16, fd00::/8".
#pragma once

#include <string_view>
#include <vector>

#include "base/ip_network.h"
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
  std::vector<base::IpNetwork> networks_;
};

}  // namespace tims::config
