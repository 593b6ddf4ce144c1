#include "tests/support/tcp_client.h"

#include <algorithm>
#include <array>
#include <cerrno>

#include <poll.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "tests/support/tcp_socket.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace {

namespace router_command = wire::router_command;

}  // namespace

Result<TcpClient> TcpClient::connect(std::string_view endpoint, Duration limit) {
  auto socket = connect_tcp(endpoint, limit);
  if (!socket) return socket.error();
  return TcpClient(*std::move(socket));
}

Result<void> TcpClient::register_mailbox(Address address, Duration limit) {
  return command(router_command::kMailboxInitWithReply, address, limit);
}

Result<void> TcpClient::delete_mailbox(Address address, Duration limit) {
  return command(router_command::kMailboxDeleteWithReply, address, limit);
}

// Messages for mailboxes that come before the answer stay where receive() finds them.
Result<void> TcpClient::command(std::int8_t type, Address mailbox, Duration limit) {
  std::array<std::byte, 4> body{};
  for (std::size_t i = 0; i < 4; ++i) {
    const std::size_t shift = 8 * (order_ == std::endian::little ? i : 3 - i);
    body[i] = static_cast<std::byte>(mailbox.raw() >> shift);
  }
  if (auto sent = send({.type = type}, body, limit); !sent) return sent;
  const Time deadline = os::deadline_after(limit);
  for (std::size_t looked_at = 0;;) {
    for (; looked_at < received_.size(); ++looked_at) {
      const Header header = received_[looked_at].header;
      if (!is_router_message(header)) continue;
      received_.erase(received_.begin() + static_cast<std::ptrdiff_t>(looked_at));
      if (header.type == type::kOk) return {};
      return Error(Errc::kAddressInUse, mailbox.to_string());
    }
    if (auto read = read_some(deadline); !read) return read;
  }
}

Result<void> TcpClient::send(Header header, std::span<const std::byte> body, Duration limit) {
  std::vector<std::byte> bytes(kHeaderSize + body.size());
  header.length = static_cast<std::uint32_t>(bytes.size());
  const auto flags = static_cast<std::uint8_t>(header.flags & ~flag::kBodyLittleEndian);
  header.flags = order_ == std::endian::little
                     ? static_cast<std::uint8_t>(flags | flag::kBodyLittleEndian)
                     : flags;
  wire::encode_header(header, wire::HeaderBytes(bytes.data(), kHeaderSize), order_);
  std::copy(body.begin(), body.end(), bytes.begin() + kHeaderSize);
  return send_bytes(bytes, limit);
}

Result<void> TcpClient::send_bytes(std::span<const std::byte> bytes, Duration limit) {
  const Time deadline = os::deadline_after(limit);
  while (!bytes.empty()) {
    const ssize_t n = ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n >= 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(n));
    } else if (errno == EPIPE || errno == ECONNRESET || errno == EBADF) {
      return Error(Errc::kClosed, "by the router");
    } else if (errno != EAGAIN && errno != EINTR) {
      return os::system_error("send");
    } else if (!wait_for(socket_, POLLOUT, deadline)) {
      return Error(Errc::kTimeout, std::to_string(bytes.size()) + " bytes not taken");
    }
  }
  return {};
}

Result<OwnedMessage> TcpClient::receive(Duration limit) {
  const Time deadline = os::deadline_after(limit);
  while (received_.empty()) {
    if (auto read = read_some(deadline); !read) return read.error();
  }
  OwnedMessage message = std::move(received_.front());
  received_.pop_front();
  return message;
}

Result<void> TcpClient::wait_for_close(Duration limit) {
  const Time deadline = os::deadline_after(limit);
  for (;;) {
    auto read = read_some(deadline);
    if (read) continue;
    if (read.error() == Errc::kClosed) return {};
    return read;
  }
}

void TcpClient::set_receive_buffer(int bytes) {
  ::setsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
}

void TcpClient::reset() { close_with_reset(socket_); }

Result<void> TcpClient::read_some(Time deadline) {
  std::array<std::byte, 64 << 10> buffer;
  for (;;) {
    const ssize_t n = ::recv(socket_.get(), buffer.data(), buffer.size(), 0);
    if (n > 0) {
      return take_messages(std::span(buffer).first(static_cast<std::size_t>(n)));
    }
    if (n == 0 || errno == ECONNRESET || errno == EBADF) {
      return Error(Errc::kClosed, "by the router");
    }
    if (errno != EAGAIN && errno != EINTR) return os::system_error("recv");
    if (!wait_for(socket_, POLLIN, deadline)) return Error(Errc::kTimeout, "no message came");
  }
}

Result<void> TcpClient::take_messages(std::span<std::byte> chunk) {
  using Status = wire::StreamReader::Status;
  for (;;) {
    const wire::StreamReader::Item item = reader_.next(chunk);
    if (item.status == Status::kNeedMore) return {};
    if (item.status != Status::kMessage) {
      const std::string length = std::to_string(item.header.length);
      return Error(Errc::kBadLayout, "the router sent a header with length " + length);
    }
    if (is_lifesign(item.header)) {
      answer_lifesign(item.header);
      continue;
    }
    const auto body = item.message.subspan(kHeaderSize);
    received_.push_back({item.header, {body.begin(), body.end()}});
  }
}

void TcpClient::answer_lifesign(const Header& lifesign) {
  ++lifesigns_;
  if (!answers_lifesigns_) return;
  // A failure shows itself with the next call.
  (void)send(wire::reply_to(lifesign, type::kOk));
}

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace tims::test
