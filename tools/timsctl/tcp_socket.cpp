#include "tools/timsctl/tcp_socket.h"

#include <cerrno>
#include <cstring>
#include <memory>
#include <string>

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "tools/timsctl/failure.h"

namespace timsctl {

namespace {

bool wait_for(int fd, short events, tims::Time deadline) {
  pollfd wait{fd, events, 0};
  const auto rest = std::max(deadline - tims::os::now(), tims::Duration::zero());
  const timespec limit = tims::os::to_timespec(tims::Time(rest));
  return ::ppoll(&wait, 1, &limit, nullptr) > 0;
}

using AddressList = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

AddressList look_up(const TcpHost& host) {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.name.c_str(), host.port.c_str(), &wanted, &found);
      error != 0)
    throw Failure(Exit::kNoRouter, "no_router", host.name + ": " + ::gai_strerror(error),
                  "check the name, or give the address");
  return {found, ::freeaddrinfo};
}

// 0, or the errno that says why not.
int try_connect(int fd, const addrinfo& address, tims::Time deadline) {
  if (::connect(fd, address.ai_addr, address.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  if (!wait_for(fd, POLLOUT, deadline)) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

}  // namespace

TcpSocket TcpSocket::connect(const TcpHost& host, tims::Duration timeout) {
  const auto addresses = look_up(host);
  const tims::Time deadline = tims::os::deadline_after(timeout);
  int error = 0;
  for (const addrinfo* a = addresses.get(); a != nullptr; a = a->ai_next) {
    tims::os::File file(::socket(a->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    error = try_connect(file.get(), *a, deadline);
    if (error != 0) continue;
    const int on = 1;
    ::setsockopt(file.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return TcpSocket(std::move(file));
  }
  throw Failure(Exit::kNoRouter, "no_router",
                "no router at " + host.to_string() + ": " + std::strerror(error),
                "a fresh router listens on loopback only: tcp.listen in its configuration");
}

tims::Result<void> TcpSocket::write_all(std::span<const std::byte> bytes, tims::Time deadline) {
  while (!bytes.empty()) {
    const ssize_t n = ::send(file_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(n));
    } else if (errno == EAGAIN) {
      if (!wait_for(file_.get(), POLLOUT, deadline)) return tims::Errc::kTimeout;
    } else if (errno != EINTR) {
      return tims::Error(tims::Errc::kClosed, std::strerror(errno));
    }
  }
  return {};
}

tims::Result<std::size_t> TcpSocket::read_some(std::span<std::byte> buffer) {
  for (;;) {
    const ssize_t n = ::recv(file_.get(), buffer.data(), buffer.size(), 0);
    if (n > 0) return static_cast<std::size_t>(n);
    if (n == 0) return tims::Error(tims::Errc::kClosed, "the router closed the connection");
    if (errno == EAGAIN) return tims::Errc::kEmpty;
    if (errno != EINTR) return tims::Error(tims::Errc::kClosed, std::strerror(errno));
  }
}

bool TcpSocket::wait_readable(tims::Time deadline) const {
  return wait_for(file_.get(), POLLIN, deadline);
}

}  // namespace timsctl
