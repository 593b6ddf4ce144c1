#include "tests/bench/blocking_socket.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/time.h>

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
  while (!bytes.empty()) {
    const ssize_t n = ::send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
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

}  // namespace tims::bench
