#include "tests/bench/udp.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <vector>

#include <arpa/inet.h>
#include <netinet/udp.h>
#include <sys/socket.h>

#include "tests/bench/addresses.h"
#include "tests/bench/sealed_burst.h"

namespace tims::bench {
namespace {

constexpr std::size_t kBurstDatagrams = 44;
constexpr int kBuffer = 16 << 20;
constexpr std::size_t kGroMax = 64 << 10;

// The size of the datagrams in a burst, received (UDP_GRO) or sent (UDP_SEGMENT).
class SegmentSize {
 public:
  explicit SegmentSize(msghdr& message) : message_(message) {
    message.msg_control = bytes_.data();
    message.msg_controllen = bytes_.size();
  }
  [[nodiscard]] int received() const {
    int size = 0;
    const cmsghdr* const control = CMSG_FIRSTHDR(&message_);
    if (control != nullptr && control->cmsg_type == UDP_GRO)
      std::memcpy(&size, CMSG_DATA(control), sizeof size);
    return size;
  }
  void attach(std::uint16_t size) {
    message_.msg_controllen = CMSG_SPACE(sizeof size);
    cmsghdr* const control = CMSG_FIRSTHDR(&message_);
    control->cmsg_level = IPPROTO_UDP;
    control->cmsg_type = UDP_SEGMENT;
    control->cmsg_len = CMSG_LEN(sizeof size);
    std::memcpy(CMSG_DATA(control), &size, sizeof size);
  }

 private:
  msghdr& message_;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> bytes_{};
};

// Datagrams received together are sent together. `seal`: null for a relay without keys.
void pass(const os::File& socket, const sockaddr_in& client, const sockaddr_in& beyond,
          std::span<std::byte> buffer, SealedBurst* seal) {
  sockaddr_in peer{};
  iovec part{buffer.data(), buffer.size()};
  msghdr message{};
  message.msg_name = &peer;
  message.msg_namelen = sizeof peer;
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  SegmentSize segment(message);
  const ssize_t n = ::recvmsg(socket.get(), &message, 0);
  if (n <= 0) return;
  const int merged = segment.received();
  const bool together = merged > 0 && merged < n;
  std::size_t size = static_cast<std::size_t>(together ? merged : n);
  part.iov_len = static_cast<std::size_t>(n);
  const bool goes_out = peer.sin_port == client.sin_port;
  peer = goes_out ? beyond : client;
  if (seal != nullptr) {
    const auto burst = buffer.first(part.iov_len);
    const auto parts = goes_out ? seal->seal(burst, size) : seal->open(burst, size);
    message.msg_iov = parts.data();
    message.msg_iovlen = parts.size();
    goes_out ? size += SealedBurst::kOverhead : size -= SealedBurst::kOverhead;
  }
  if (together) {
    segment.attach(static_cast<std::uint16_t>(size));
  } else {
    message.msg_controllen = 0;
  }
  ::sendmsg(socket.get(), &message, 0);
}

}  // namespace

Result<sockaddr_in> udp_address(const std::string& endpoint) {
  const std::size_t colon = endpoint.find(':');
  sockaddr_in address{};
  address.sin_family = AF_INET;
  const std::string host = endpoint.substr(0, colon);
  if (colon == std::string::npos || ::inet_pton(AF_INET, host.c_str(), &address.sin_addr) != 1)
    return Error(Errc::kInvalidArgument, endpoint + " is not address:port");
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(endpoint.substr(colon + 1))));
  return address;
}

Result<os::File> open_udp(const std::string& endpoint) {
  const auto address = udp_address(endpoint);
  if (!address) return address.error();
  os::File socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const int on = 1;
  ::setsockopt(socket.get(), SOL_SOCKET, SO_RCVBUFFORCE, &kBuffer, sizeof kBuffer);
  ::setsockopt(socket.get(), SOL_SOCKET, SO_SNDBUFFORCE, &kBuffer, sizeof kBuffer);
  ::setsockopt(socket.get(), IPPROTO_UDP, UDP_GRO, &on, sizeof on);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0)
    return os::system_error("UDP " + endpoint);
  return socket;
}

bool send_trains(const os::File& socket, std::size_t datagram, std::span<const std::byte> first,
                 std::span<const std::byte> second) {
  const std::size_t burst = kBurstDatagrams * datagram;
  while (!first.empty() || !second.empty()) {
    const auto a = first.first(std::min(first.size(), burst));
    const auto b = second.first(std::min(second.size(), burst - a.size()));
    std::array<iovec, 2> parts{{{const_cast<std::byte*>(a.data()), a.size()},
                                {const_cast<std::byte*>(b.data()), b.size()}}};
    msghdr message{};
    message.msg_iov = parts.data();
    message.msg_iovlen = parts.size();
    SegmentSize segment(message);
    if (a.size() + b.size() > datagram) {
      segment.attach(static_cast<std::uint16_t>(datagram));
    } else {
      message.msg_controllen = 0;
    }
    if (::sendmsg(socket.get(), &message, 0) < 0) return false;
    first = first.subspan(a.size());
    second = second.subspan(b.size());
  }
  return true;
}

bool run_udp_relay(const std::string& host, const std::string& endpoint, bool sealed) {
  const auto socket = open_udp(host + kRouterPort);
  const auto client = udp_address(host + kClientPort);
  const auto beyond = udp_address(endpoint);
  if (!socket || !client || !beyond) return false;
  std::fprintf(stderr, "listening udp %s%s\n", host.c_str(), kRouterPort);
  std::vector<std::byte> buffer(kGroMax);
  SealedBurst seal;
  for (;;) pass(*socket, *client, *beyond, buffer, sealed ? &seal : nullptr);
}

}  // namespace tims::bench
