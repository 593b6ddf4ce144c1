#include "tests/support/tcp_socket.h"

#include <arpa/inet.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/socket.h"
#include "wire/endpoint.h"

namespace tims::test {

Result<os::File> connect_tcp(std::string_view endpoint, Duration limit) {
  const auto parsed = wire::parse_endpoint(endpoint);
  const auto* tcp = parsed ? std::get_if<wire::TcpEndpoint>(&*parsed) : nullptr;
  const bool has_port = endpoint.find(':') != std::string_view::npos;
  if (tcp == nullptr || !has_port)
    return Error(Errc::kInvalidArgument, std::string(endpoint) + " is not host:port");
  auto socket = os::connect_tcp(tcp->host, tcp->port, os::deadline_after(limit));
  if (!socket)
    return Error(socket.error().code(), std::string(endpoint) + ": " + socket.error().detail());
  return socket;
}

Result<Listener> listen_tcp() {
  Listener listener{os::File(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)), 0};
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* const generic = reinterpret_cast<sockaddr*>(&address);
  const int fd = listener.socket.get();
  if (::bind(fd, generic, size) != 0) return os::system_error("bind");
  if (::listen(fd, SOMAXCONN) != 0) return os::system_error("listen");
  if (::getsockname(fd, generic, &size) != 0) return os::system_error("getsockname");
  listener.port = ntohs(address.sin_port);
  return listener;
}

void close_with_reset(os::File& socket) {
  const linger at_once{.l_onoff = 1, .l_linger = 0};
  ::setsockopt(socket.get(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  socket.reset();
}

}  // namespace tims::test
