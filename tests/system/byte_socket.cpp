#include "tests/system/byte_socket.h"

#include <array>
#include <cerrno>

#include <poll.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/wakeup.h"
#include "tests/support/patience.h"
#include "tests/support/tcp_socket.h"

namespace tims::test {

ByteSocket::ByteSocket(std::string_view endpoint) {
  auto connected = connect_tcp(endpoint, kPatience);
  closed_ = !connected.ok();
  if (connected) socket_ = std::move(*connected);
}

bool ByteSocket::send(std::string_view bytes) {
  const Time deadline = os::deadline_after(kPatience);
  while (!bytes.empty() && !closed_) {
    bytes.remove_prefix(send_some(bytes));
    if (!bytes.empty() && !os::is_ready(socket_.get(), POLLOUT, deadline)) return false;
  }
  return bytes.empty();
}

std::size_t ByteSocket::send_some(std::string_view bytes) {
  const ssize_t n = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  if (n < 0 && errno != EAGAIN) closed_ = true;
  return n < 0 ? 0 : static_cast<std::size_t>(n);
}

void ByteSocket::shut_down_sending() { ::shutdown(socket_.get(), SHUT_WR); }

void ByteSocket::close() {
  socket_.reset();
  closed_ = true;
}

void ByteSocket::set_receive_buffer(int bytes) {
  ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
}

std::string ByteSocket::take(std::size_t size) {
  while (received_.size() < size && receive()) {
  }
  std::string taken = received_.substr(0, size);
  received_.erase(0, size);
  return taken;
}

std::string ByteSocket::take_until(std::string_view end) {
  while (received_.find(end) == std::string::npos && receive()) {
  }
  const std::size_t at = received_.find(end);
  return take(at == std::string::npos ? received_.size() : at + end.size());
}

std::string ByteSocket::take_rest() {
  while (receive()) {
  }
  return take(received_.size());
}

bool ByteSocket::has_input() {
  return !received_.empty() || os::is_ready(socket_.get(), POLLIN, os::now());
}

// False at the deadline and when the other side has closed.
bool ByteSocket::receive() {
  if (closed_ || !os::is_ready(socket_.get(), POLLIN, os::deadline_after(kPatience))) return false;
  std::array<char, 65536> bytes;
  const ssize_t n = ::recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (n > 0) received_.append(bytes.data(), static_cast<std::size_t>(n));
  closed_ = n == 0 || (n < 0 && errno != EAGAIN);
  return !closed_;
}

}  // namespace tims::test
