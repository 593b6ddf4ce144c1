#include "router/io/tcp_connection.h"

#include <algorithm>
#include <array>
#include <cerrno>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/uio.h>

namespace tims::io {
namespace {

void set(int socket, int level, int option, int value) {
  ::setsockopt(socket, level, option, &value, sizeof value);
}

// Many original clients switch the lifesign off: the system finds those whose machine has gone.
void find_dead_peers(int socket) {
  constexpr int kIdleSeconds = 30;
  constexpr int kProbeSeconds = 10;
  constexpr int kProbes = 3;
  set(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
  set(socket, IPPROTO_TCP, TCP_KEEPIDLE, kIdleSeconds);
  set(socket, IPPROTO_TCP, TCP_KEEPINTVL, kProbeSeconds);
  set(socket, IPPROTO_TCP, TCP_KEEPCNT, kProbes);
}

// On a network, how much the system may hold that is not on its way yet: what waits beyond that
// waits in our own queue, where urgent messages overtake. Within this host it would only cost
// copies.
constexpr int kUnsentBytesMax = 256 << 10;

bool is_on_this_host(int socket) {
  sockaddr_storage peer{};
  socklen_t size = sizeof peer;
  if (::getpeername(socket, reinterpret_cast<sockaddr*>(&peer), &size) != 0) return true;
  if (peer.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(peer);
    return ntohl(v4.sin_addr.s_addr) >> 24 == IN_LOOPBACKNET;
  }
  return IN6_IS_ADDR_LOOPBACK(&reinterpret_cast<const sockaddr_in6&>(peer).sin6_addr);
}

}  // namespace

TcpConnection::TcpConnection(os::File its_socket, std::uint32_t message_max, core::BlockPool& pool,
                             std::uint64_t queue_bytes_max, const core::PriorityClasses& classes)
    : socket(std::move(its_socket)),
      reader(message_max),
      output(socket.get(), pool, queue_bytes_max, classes) {
  set(socket.get(), IPPROTO_TCP, TCP_NODELAY, 1);
  if (!is_on_this_host(socket.get())) {
    set(socket.get(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, kUnsentBytesMax);
  }
  find_dead_peers(socket.get());
}

TcpConnection::Read TcpConnection::read(std::span<std::byte> scratch) {
  const std::span<std::byte> room = reader.room();
  std::array<iovec, 2> pieces{iovec{room.data(), room.size()},
                              iovec{scratch.data(), scratch.size()}};
  const bool to_room = !room.empty();
  msghdr message{};
  message.msg_iov = pieces.data() + (to_room ? 0 : 1);
  message.msg_iovlen = to_room ? 2 : 1;
  const ssize_t n = ::recvmsg(socket.get(), &message, MSG_DONTWAIT);
  if (n == 0) return {ReadStatus::kClosed, {}};
  if (n < 0) {
    const bool later = errno == EAGAIN || errno == EINTR;
    return {later ? ReadStatus::kNothing : ReadStatus::kLost, {}};
  }
  const auto size = static_cast<std::size_t>(n);
  const std::size_t in_room = std::min(size, room.size());
  if (in_room > 0) reader.advance(in_room);
  return {ReadStatus::kSome, scratch.first(size - in_room)};
}

}  // namespace tims::io
