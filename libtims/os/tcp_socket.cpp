#include "os/tcp_socket.h"

#include <algorithm>
#include <array>
#include <memory>

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include "os/clock.h"

namespace tims::os {

namespace {

using AddressList = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

Result<AddressList> look_up(const std::string& host, std::uint16_t port) {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &wanted, &found);
  if (error != 0) return Error(Errc::kSystem, ::gai_strerror(error));
  return AddressList(found, ::freeaddrinfo);
}

// 0, or the errno that says why not.
int wait_connected(int socket, Time deadline, int cancel) {
  std::array<pollfd, 2> waits{{{socket, POLLOUT, 0}, {cancel, POLLIN, 0}}};
  int ready = -1;
  do {
    const timespec rest = to_timespec(Time(std::max(deadline - now(), Duration::zero())));
    ready = ::ppoll(waits.data(), waits.size(), &rest, nullptr);
  } while (ready < 0 && errno == EINTR);
  if (waits[1].revents != 0) return ECANCELED;
  if (waits[0].revents == 0) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

int try_connect(int socket, const addrinfo& address, Time deadline, int cancel) {
  if (::connect(socket, address.ai_addr, address.ai_addrlen) == 0) return 0;
  return errno == EINPROGRESS ? wait_connected(socket, deadline, cancel) : errno;
}

void set(int socket, int level, int option, int value) {
  ::setsockopt(socket, level, option, &value, sizeof value);
}

// Also one that stands still for so long while messages wait for it.
void find_dead_router(int socket) {
  constexpr int kIdleSeconds = 10;
  constexpr int kProbeSeconds = 2;
  constexpr int kProbes = 3;
  constexpr int kUnansweredMs = 20'000;
  set(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
  set(socket, IPPROTO_TCP, TCP_KEEPIDLE, kIdleSeconds);
  set(socket, IPPROTO_TCP, TCP_KEEPINTVL, kProbeSeconds);
  set(socket, IPPROTO_TCP, TCP_KEEPCNT, kProbes);
  set(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, kUnansweredMs);
}

}  // namespace

Result<File> connect_tcp(const std::string& host, std::uint16_t port, Time deadline, int cancel) {
  const auto addresses = look_up(host, port);
  if (!addresses) return addresses.error();
  for (const addrinfo* a = addresses->get(); a != nullptr; a = a->ai_next) {
    File socket(::socket(a->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    errno = socket ? try_connect(socket.get(), *a, deadline, cancel) : errno;
    if (errno != 0) continue;
    set(socket.get(), IPPROTO_TCP, TCP_NODELAY, 1);
    find_dead_router(socket.get());
    return socket;
  }
  return Error(Errc::kSystem, std::generic_category().message(errno));
}

}  // namespace tims::os
