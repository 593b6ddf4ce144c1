#include "tools/timsctl/tcp_socket.h"

#include <cerrno>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>

#include <poll.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/socket.h"
#include "tools/timsctl/failure.h"

namespace timsctl {

namespace {

bool wait_for(int fd, short events, tims::Time deadline) {
  pollfd wait{fd, events, 0};
  const auto rest = std::max(deadline - tims::os::now(), tims::Duration::zero());
  const timespec limit = tims::os::to_timespec(tims::Time(rest));
  return ::ppoll(&wait, 1, &limit, nullptr) > 0;
}

std::string hint_for(std::string_view why, const TcpHost& host) {
  const auto is = [&](int error) { return why == std::generic_category().message(error); };
  if (is(ECONNREFUSED))
    return "a fresh router listens on loopback only: tcp.listen in its configuration";
  if (is(ETIMEDOUT) || is(EHOSTUNREACH) || is(ENETUNREACH))
    return "is that host up, and its network? A firewall may drop what comes to port " +
           std::to_string(host.port);
  return "that name has no address: is it spelt so? `getent hosts " + host.host + "`";
}

}  // namespace

TcpSocket TcpSocket::connect(const TcpHost& host, tims::Duration timeout) {
  auto file = tims::os::connect_tcp(host.host, host.port, tims::os::deadline_after(timeout));
  if (file) return TcpSocket(std::move(*file));
  const std::string& why = file.error().detail();
  throw Failure(Exit::kNoRouter, "no_router", "no router at " + to_string(host) + ": " + why,
                hint_for(why, host));
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
