// Text forms of the location of a router:
//
//   unix:PATH, /PATH or ./PATH              the Unix socket of this host's router
//   tls:HOST:PORT, tls:HOST                 through TLS with the keys of this host
//   tls:HOST:PORT/NAME                      likewise, to the router that has this name in its
//                                           certificate
//   HOST:PORT, HOST, [IPv6]:PORT or IPv6    over TCP; the default port is 2000
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "tims/result.h"

namespace tims::wire {

struct UnixEndpoint {
  std::string path;
  bool operator==(const UnixEndpoint&) const = default;
};
struct TcpEndpoint {
  static constexpr std::uint16_t kDefaultPort = 2000;  // the original's

  std::string host;
  std::uint16_t port = kDefaultPort;
  bool tls = false;
  std::string name{};  // of the router, with `tls`; empty: the one whose certificate has the host
  bool operator==(const TcpEndpoint&) const = default;
};
using Endpoint = std::variant<UnixEndpoint, TcpEndpoint>;

// kInvalidArgument: the detail states what is wrong, and lists the valid forms.
Result<Endpoint> parse_endpoint(std::string_view text);
// "/run/tims/router.sock", "robot:2000", "[::1]:2000", "tls:robot:2000/robot3"
std::string to_string(const TcpEndpoint& endpoint);
std::string to_string(const Endpoint& endpoint);

}  // namespace tims::wire
