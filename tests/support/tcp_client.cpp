#include "tests/support/tcp_client.h"

#include <cerrno>

#include <poll.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/wakeup.h"
#include "tests/support/tcp_socket.h"

namespace tims::test {

Result<TcpClient> TcpClient::connect(std::string_view endpoint, Duration limit) {
  auto socket = connect_tcp(endpoint, limit);
  if (!socket) return socket.error();
  return TcpClient(*std::move(socket));
}

Result<void> TcpClient::register_mailbox(Address address, Duration limit) {
  return client_.register_mailbox(address, os::deadline_after(limit));
}

Result<void> TcpClient::delete_mailbox(Address address, Duration limit) {
  return client_.delete_mailbox(address, os::deadline_after(limit));
}

Result<void> TcpClient::send(Header header, std::span<const std::byte> body, Duration limit) {
  const auto flags = static_cast<std::uint8_t>(header.flags & ~flag::kBodyLittleEndian);
  header.flags = static_cast<std::uint8_t>(flags | client_.protocol().body_order());
  return client_.send(header, body, os::deadline_after(limit));
}

Result<void> TcpClient::send_bytes(std::span<const std::byte> bytes, Duration limit) {
  const Time deadline = os::deadline_after(limit);
  if (auto flushed = client_.flush(deadline); !flushed) return flushed;
  while (!bytes.empty()) {
    const ssize_t n = ::send(client_.socket().get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n >= 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(n));
    } else if (errno == EPIPE || errno == ECONNRESET || errno == EBADF) {
      return Error(Errc::kClosed, "by the router");
    } else if (errno != EAGAIN && errno != EINTR) {
      return os::system_error("send");
    } else if (!os::is_ready(client_.socket().get(), POLLOUT, deadline)) {
      return Error(Errc::kTimeout, std::to_string(bytes.size()) + " bytes not taken");
    }
  }
  return {};
}

Result<OwnedMessage> TcpClient::receive(Duration limit) {
  if (before_close_.empty()) return client_.receive(os::deadline_after(limit));
  OwnedMessage message = std::move(before_close_.front());
  before_close_.pop_front();
  return message;
}

Result<void> TcpClient::wait_for_close(Duration limit) {
  const Time deadline = os::deadline_after(limit);
  for (;;) {
    auto message = client_.receive(deadline);
    if (message) {
      before_close_.push_back(std::move(*message));
    } else if (message.error() == Errc::kClosed) {
      return {};
    } else {
      return message.error();
    }
  }
}

void TcpClient::set_receive_buffer(int bytes) {
  ::setsockopt(client_.socket().get(), SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
}

void TcpClient::reset() { close_with_reset(client_.socket()); }

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace tims::test
