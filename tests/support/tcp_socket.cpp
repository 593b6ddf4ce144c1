#include "tests/support/tcp_socket.h"

#include <algorithm>
#include <memory>

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include "os/clock.h"

namespace tims::test {
namespace {

using AddressList = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

Result<AddressList> resolve(std::string_view endpoint) {
  const std::size_t colon = endpoint.rfind(':');
  if (colon == std::string_view::npos) {
    return Error(Errc::kInvalidArgument, std::string(endpoint) + " is not host:port");
  }
  const std::string host(endpoint.substr(0, colon));
  const std::string port(endpoint.substr(colon + 1));
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(host.c_str(), port.c_str(), &hints, &found);
  if (error != 0) return Error(Errc::kInvalidArgument, host + ": " + ::gai_strerror(error));
  return AddressList(found, &::freeaddrinfo);
}

Result<os::File> connect_to(const addrinfo& address, Time deadline) {
  os::File socket(::socket(address.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) return os::system_error("socket");
  const int on = 1;
  ::setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  if (::connect(socket.get(), address.ai_addr, address.ai_addrlen) == 0) return socket;
  if (errno != EINPROGRESS) return os::system_error("connect");
  if (!wait_for(socket, POLLOUT, deadline)) return Error(Errc::kTimeout, "connect");
  socklen_t size = sizeof errno;
  ::getsockopt(socket.get(), SOL_SOCKET, SO_ERROR, &errno, &size);
  if (errno != 0) return os::system_error("connect");
  return socket;
}

}  // namespace

Result<os::File> connect_tcp(std::string_view endpoint, Duration limit) {
  const Time deadline = os::deadline_after(limit);
  const auto addresses = resolve(endpoint);
  if (!addresses) return addresses.error();
  Result<os::File> socket = Errc::kInvalidArgument;
  for (const addrinfo* a = addresses->get(); a != nullptr && !socket; a = a->ai_next) {
    socket = connect_to(*a, deadline);
  }
  if (!socket) {
    return Error(socket.error().code(), std::string(endpoint) + ": " + socket.error().detail());
  }
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

bool wait_for(const os::File& socket, short events, Time deadline) {
  pollfd ready{socket.get(), events, 0};
  for (;;) {
    const Duration rest = std::max(deadline - os::now(), Duration::zero());
    const timespec timeout = os::to_timespec(Time(rest));
    const int n = ::ppoll(&ready, 1, &timeout, nullptr);
    if (n > 0) return true;
    if (n == 0) return false;
  }
}

}  // namespace tims::test
