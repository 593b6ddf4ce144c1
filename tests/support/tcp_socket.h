// Opens and closes TCP connections in tests. All sockets are non-blocking; waits have a deadline.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "os/file.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::test {

// `endpoint` is "host:port". TCP_NODELAY is set.
Result<os::File> connect_tcp(std::string_view endpoint, Duration limit);

// A listening socket on a free port of the loopback, and that port.
struct Listener {
  os::File socket;
  std::uint16_t port = 0;
  [[nodiscard]] std::string endpoint() const { return "127.0.0.1:" + std::to_string(port); }
};
Result<Listener> listen_tcp();

// Closes with a reset instead of an orderly end; the other side loses bytes it has not read.
void close_with_reset(os::File& socket);

}  // namespace tims::test
