#include "tests/bench/tcp_bytes.h"

#include <algorithm>
#include <cstring>

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/time.h>

#include "libtims/wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::bench {

void make_blocking(const os::File& socket) {
  ::fcntl(socket.get(), F_SETFL, ::fcntl(socket.get(), F_GETFL) & ~O_NONBLOCK);
}

void set_read_timeout(const os::File& socket, Duration timeout) {
  const Duration finite = timeout == kForever ? Duration::zero() : timeout;  // zero: no limit
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(finite).count();
  const timeval limit{us / 1'000'000, us % 1'000'000};
  ::setsockopt(socket.get(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
}

bool write_all(const os::File& socket, std::span<const std::byte> bytes) {
  return write_both(socket, bytes, {});
}

bool write_both(const os::File& socket, std::span<const std::byte> first,
                std::span<const std::byte> second) {
  while (!first.empty() || !second.empty()) {
    std::array<iovec, 2> parts{{{const_cast<std::byte*>(first.data()), first.size()},
                                {const_cast<std::byte*>(second.data()), second.size()}}};
    msghdr message{};
    message.msg_iov = parts.data();
    message.msg_iovlen = parts.size();
    const ssize_t n = ::sendmsg(socket.get(), &message, MSG_NOSIGNAL);
    if (n <= 0) return false;
    const std::size_t of_first = std::min(static_cast<std::size_t>(n), first.size());
    first = first.subspan(of_first);
    second = second.subspan(static_cast<std::size_t>(n) - of_first);
  }
  return true;
}

bool read_exactly(const os::File& socket, std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::recv(socket.get(), bytes.data(), bytes.size(), 0);
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

std::array<std::byte, kInitBytes> init_of(Address address) {
  std::array<std::byte, kInitBytes> bytes{};
  const std::span all(bytes);
  wire::encode_header({.type = wire::router_command::kMailboxInitWithReply, .length = kInitBytes},
                      all.first<kHeaderSize>());
  const std::uint32_t raw = address.raw();
  std::memcpy(&bytes[kHeaderSize], &raw, sizeof raw);
  return bytes;
}

std::array<std::byte, kHeaderSize + kInitBytes> registration_of(Address address) {
  std::array<std::byte, kHeaderSize + kInitBytes> bytes{};
  const std::span all(bytes);
  wire::encode_header({.type = wire::router_command::kDisableWatchdog}, all.first<kHeaderSize>());
  std::ranges::copy(init_of(address), all.begin() + kHeaderSize);
  return bytes;
}

}  // namespace tims::bench
