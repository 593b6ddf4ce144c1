// Which router -H names.
#pragma once

#include <string>
#include <string_view>
#include <variant>

namespace timsctl {

struct UnixHost {
  std::string path;
  bool operator==(const UnixHost&) const = default;
};
struct TcpHost {
  std::string name;
  std::string port = "2000";
  bool operator==(const TcpHost&) const = default;
  [[nodiscard]] std::string to_string() const { return name + ":" + port; }
};
using Host = std::variant<UnixHost, TcpHost>;

// "robot", "robot:2000", "[::1]:2000", "::1", "unix:/run/tims/router.sock", "/run/tims/x.sock".
// Throws Failure when it is none of these.
Host parse_host(std::string_view text);
std::string to_string(const Host& host);

}  // namespace timsctl
