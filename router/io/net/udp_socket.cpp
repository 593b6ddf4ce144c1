#include "router/io/net/udp_socket.h"

#include <cerrno>

#include <netinet/udp.h>

#include "os/bind.h"
#include "router/io/net/system_address.h"

namespace tims::io {
namespace {

bool set(int socket, int level, int option, int value) {
  return ::setsockopt(socket, level, option, &value, sizeof value) == 0;
}

std::uint32_t buffer_size(int socket, int option) {
  int bytes = 0;
  socklen_t size = sizeof bytes;
  ::getsockopt(socket, SOL_SOCKET, option, &bytes, &size);
  return static_cast<std::uint32_t>(bytes) / 2;
}

Error cannot_open(const config::Endpoint& where) {
  const Errc code = errno == EADDRINUSE ? Errc::kAddressInUse : Errc::kSystem;
  return {code, os::system_error("UDP " + where.to_string()).detail()};
}

}  // namespace

UdpSocket::UdpSocket(os::File file, int family, const UdpOptions& options)
    : file_(std::move(file)), family_(family), options_(options) {}

Result<UdpSocket> UdpSocket::open(const config::Endpoint& where, const UdpOptions& options) {
  const auto address = numeric_address(where.host, where.port);
  if (!address) {
    return Error(Errc::kInvalidArgument,
                 "UDP " + where.to_string() + ": not a numeric address of this host");
  }
  const int family = address->is_v4() ? AF_INET : AF_INET6;
  os::File file(::socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, IPPROTO_UDP));
  if (!file) return cannot_open(where);
  UdpSocket socket(std::move(file), family, options);
  socket.request_buffers();
  socket.set_options();
  if (!socket.bind(*address)) return cannot_open(where);
  return socket;
}

// Root may have more than net.core.rmem_max and wmem_max.
void UdpSocket::request_buffers() {
  const int bytes = static_cast<int>(options_.buffer_bytes);
  if (!set(fd(), SOL_SOCKET, SO_RCVBUFFORCE, bytes)) set(fd(), SOL_SOCKET, SO_RCVBUF, bytes);
  if (!set(fd(), SOL_SOCKET, SO_SNDBUFFORCE, bytes)) set(fd(), SOL_SOCKET, SO_SNDBUF, bytes);
  receive_buffer_bytes_ = buffer_size(fd(), SO_RCVBUF);
  send_buffer_bytes_ = buffer_size(fd(), SO_SNDBUF);
}

// PROBE: does not fragment, and does not believe what ICMP says about the path, which anybody can
// forge: links measure it themselves. Errors are not asked for (IP_RECVERR): same reason.
void UdpSocket::set_options() {
  set(fd(), IPPROTO_IP, IP_MTU_DISCOVER, options_.fragments ? IP_PMTUDISC_DONT : IP_PMTUDISC_PROBE);
  if (family_ == AF_INET6) {
    set(fd(), IPPROTO_IPV6, IPV6_V6ONLY, 0);
    set(fd(), IPPROTO_IPV6, IPV6_MTU_DISCOVER,
        options_.fragments ? IPV6_PMTUDISC_DONT : IPV6_PMTUDISC_PROBE);
  }
  set(fd(), SOL_UDP, UDP_GRO, 1);
  set(fd(), SOL_SOCKET, SO_RXQ_OVFL, 1);
  // An older kernel would ignore the size beside a train and send it as one datagram.
  if (!set(fd(), SOL_UDP, UDP_SEGMENT, 0)) options_.segmentation = false;
}

bool UdpSocket::bind(const link::NetAddress& where) {
  auto address = system_address(where, family_);
  if (!address) return false;
  const os::Bound bound = os::bind_even_early(fd(), address->get(), address->size);
  if (bound == os::Bound::kNo) return false;
  is_early_ = bound == os::Bound::kAddressNotHereYet;
  address->size = sizeof address->storage;
  if (::getsockname(fd(), address->get(), &address->size) != 0) return false;
  local_ = address->net_address();
  return true;
}

bool UdpSocket::receive(Datagrams& into) {
  const Datagrams::Outcome outcome = into.receive(fd());
  counters_.truncated += outcome.truncated;
  if (const auto drops = outcome.dropped_by_kernel) {
    counters_.dropped_by_kernel += *drops - kernel_drops_;  // the kernel's number wraps around
    kernel_drops_ = *drops;
  }
  return outcome.messages > 0;
}

}  // namespace tims::io
