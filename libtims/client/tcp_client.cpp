#include "client/tcp_client.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <string>

#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include "os/clock.h"
#include "os/socket.h"
#include "os/tunnel.h"
#include "os/wakeup.h"

namespace tims::client {

namespace {

namespace router_command = wire::router_command;

constexpr std::size_t kScratchBytes = 64 << 10;
constexpr std::size_t kCopiedMax = 16 << 10;  // larger bodies are sent without a copy

Error closed_by_router() { return {Errc::kClosed, "the router closed the connection"}; }

Error failed(const char* call) {
  if (errno == EPIPE || errno == ECONNRESET || errno == EBADF) return closed_by_router();
  return os::system_error(call);
}

}  // namespace

TcpClient::TcpClient(os::File socket, std::uint32_t received_max)
    : socket_(std::move(socket)), protocol_(received_max), scratch_(kScratchBytes) {}

Result<TcpClient> TcpClient::connect(const wire::TcpEndpoint& router, Time deadline,
                                     std::uint32_t received_max, int cancel) {
  wire::TcpEndpoint inner = router;
  inner.tls = false;
  auto socket = router.tls ? os::connect_by_tunnel(wire::to_string(inner))
                           : os::connect_tcp(router.host, router.port, deadline, cancel);
  if (!socket) return socket.error();
  return TcpClient(std::move(*socket), received_max);
}

// --- Sending

Result<void> TcpClient::flush() {
  for (auto rest = protocol_.unsent(); !rest.empty(); rest = protocol_.unsent()) {
    const ssize_t n = ::send(socket_.get(), rest.data(), rest.size(), MSG_NOSIGNAL);
    if (n >= 0) {
      protocol_.sent(static_cast<std::size_t>(n));
    } else if (errno == EAGAIN) {
      return Errc::kEmpty;
    } else if (errno != EINTR) {
      return failed("send");
    }
  }
  return {};
}

Result<void> TcpClient::flush(Time deadline) {
  for (;;) {
    auto flushed = flush();
    if (flushed || !(flushed.error() == Errc::kEmpty)) return flushed;
    if (!os::is_ready(socket_.get(), POLLOUT, deadline)) return Errc::kTimeout;
  }
}

// The rest of a partly sent message is copied, because the next message is appended to it.
Result<void> TcpClient::send(const Header& header, std::span<const std::byte> body, Time deadline) {
  if (body.size() <= kCopiedMax) {
    protocol_.put(header, body);
    return flush(deadline);
  }
  if (auto flushed = flush(deadline); !flushed) return flushed;
  auto head = protocol_.encode(header, body.size());
  std::array<iovec, 2> pieces{iovec{head.data(), head.size()},
                              iovec{const_cast<std::byte*>(body.data()), body.size()}};
  msghdr message{};
  message.msg_iov = pieces.data();
  message.msg_iovlen = pieces.size();
  const ssize_t n = ::sendmsg(socket_.get(), &message, MSG_NOSIGNAL);
  if (n < 0 && errno != EAGAIN && errno != EINTR) return failed("send");
  const auto sent = static_cast<std::size_t>(std::max<ssize_t>(n, 0));
  if (sent == head.size() + body.size()) return {};
  protocol_.put(header, body);
  protocol_.sent(sent);
  return flush(deadline);
}

// --- Receiving

// Reads into the buffer of a large message that is incomplete; bytes beyond it go to the chunk.
Result<std::span<std::byte>> TcpClient::read_chunk() {
  if (broken_) return *broken_;
  const std::span<std::byte> room = protocol_.room();
  std::array<iovec, 2> pieces{iovec{room.data(), room.size()},
                              iovec{scratch_.data(), scratch_.size()}};
  msghdr message{};
  message.msg_iov = pieces.data() + (room.empty() ? 1 : 0);
  message.msg_iovlen = room.empty() ? 1 : 2;
  const ssize_t n = ::recvmsg(socket_.get(), &message, 0);
  if (n == 0) return closed_by_router();
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return Errc::kEmpty;
  if (n < 0) return failed("recv");
  const auto size = static_cast<std::size_t>(n);
  const std::size_t in_room = std::min(size, room.size());
  if (in_room > 0) protocol_.advance(in_room);
  return std::span(scratch_).first(size - in_room);
}

Error TcpClient::broken(const Header& header) {
  constexpr std::string_view kHttp = "HTTP/";
  std::array<std::byte, kHeaderSize> bytes;
  wire::encode_header(header, bytes, std::endian::big);
  const std::string size = "a message of " + std::to_string(header.length) + " bytes";
  if (std::ranges::equal(std::span(bytes).first(kHttp.size()), std::as_bytes(std::span(kHttp)))) {
    broken_.emplace(Errc::kVersion, "it answers in HTTP: no router's TCP port");
  } else if (header.length < kHeaderSize) {
    broken_.emplace(Errc::kMalformed, size);
  } else {
    broken_.emplace(Errc::kTooBig, size + " from " + header.src.to_string(protocol_.widths()));
  }
  return *broken_;
}

Result<Message> TcpClient::take() {
  if (received_.empty()) {
    auto got = read([this](const Header& header, std::span<const std::byte> body) {
      received_.push_back({header, {body.begin(), body.end()}});
    });
    const auto answered = flush();  // answers to lifesigns; the rest is sent with the next output
    if (!got && received_.empty()) return got.error();
    if (!answered && answered.error() == Errc::kClosed && received_.empty())
      return answered.error();
  }
  if (received_.empty()) return Errc::kEmpty;
  Message message = std::move(received_.front());
  received_.pop_front();
  return message;
}

Result<Message> TcpClient::receive(Time deadline) {
  for (;;) {
    auto message = take();
    if (message || !(message.error() == Errc::kEmpty)) return message;
    if (!os::is_ready(socket_.get(), POLLIN, deadline)) return Errc::kTimeout;
  }
}

// --- Replies of the router

Result<void> TcpClient::log_in(Time deadline) {
  protocol_.put_command(router_command::kLogin, {});
  auto confirmed = is_confirmed(router_command::kMailboxDeleteWithReply, {}, deadline);
  if (!confirmed) return confirmed.error();
  return {};
}

Result<void> TcpClient::register_mailbox(Address address, Time deadline) {
  auto done = is_confirmed(router_command::kMailboxInitWithReply, address, deadline);
  if (!done) return done.error();
  if (!*done) return Error(Errc::kAddressInUse, address.to_string(protocol_.widths()));
  return {};
}

Result<void> TcpClient::delete_mailbox(Address address, Time deadline) {
  auto done = is_confirmed(router_command::kMailboxDeleteWithReply, address, deadline);
  if (!done) return done.error();
  if (!*done) return Error(Errc::kNoMailbox, address.to_string(protocol_.widths()));
  return {};
}

// OK or ERROR.
Result<bool> TcpClient::is_confirmed(std::int8_t command, Address mailbox, Time deadline) {
  protocol_.put_command(command, mailbox);
  if (auto flushed = flush(deadline); !flushed) return flushed.error();
  std::deque<Message> meanwhile = std::move(received_);
  received_.clear();
  for (;;) {
    auto message = receive(deadline);
    const bool is_reply = message && wire::is_router_message(message->header);
    if (message && !is_reply) {
      meanwhile.push_back(std::move(*message));
      continue;
    }
    std::ranges::move(received_, std::back_inserter(meanwhile));
    received_ = std::move(meanwhile);
    if (!message) return message.error();
    return message->header.type == type::kOk;
  }
}

}  // namespace tims::client
