#include "client/tcp_bridge.h"

#include <algorithm>
#include <cerrno>

#include <poll.h>
#include <pthread.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include "os/event_fd.h"
#include "wire/header.h"
#include "wire/router_commands.h"

namespace tims::client {

namespace {

namespace router_command = wire::router_command;

// Of what a router may send. What a mailbox does not take, it counts; only what no router would
// send ends the connection.
constexpr std::uint32_t kReceivedMax = 16U << 20;
constexpr std::size_t kScratchBytes = 64 << 10;
constexpr int kWritesPerTurn = 8;
// A router that asks and asks, and takes no answer, gets no more of them.
constexpr std::size_t kAnswersBytesMax = 1 << 20;

}  // namespace

TcpBridge::TcpBridge(os::File router, os::File session, Settings settings)
    : settings_(std::move(settings)),
      router_(std::move(router)),
      session_(std::move(session)),
      reader_(std::max(settings_.message_max, kReceivedMax)),
      scratch_(kScratchBytes),
      thread_([this] { run(); }) {}

TcpBridge::~TcpBridge() { thread_.join(); }

void TcpBridge::run() {
  ::pthread_setname_np(::pthread_self(), "tims-tcp");
  const sched_param priority{.sched_priority = settings_.priority};
  if (priority.sched_priority > 0)
    (void)::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority);
  while (turn()) {
  }
  session_.reset();
  router_.reset();
}

// Sends what there is to send, and waits for the next thing to do.
bool TcpBridge::turn() {
  if (!write_router()) return false;
  const bool full = !written();
  const short router_events = static_cast<short>(full ? POLLIN | POLLOUT : POLLIN);
  const int doorbell = uplink_ && !full ? uplink_->doorbell().get() : -1;
  std::array<pollfd, 3> waits{
      {{session_.get(), POLLIN, 0}, {router_.get(), router_events, 0}, {doorbell, POLLIN, 0}}};
  if (::poll(waits.data(), waits.size(), more_ ? 0 : -1) < 0) return errno == EINTR;
  if (waits[2].revents != 0) os::drain_event_fd(doorbell);
  if (waits[1].revents != 0 && !read_router()) return false;
  return (waits[0].revents == 0 || read_session()) && !failed_;
}

// --- to the router

// What waits in the uplink, as far as the socket takes it, but not for ever. False: lost.
bool TcpBridge::write_router() {
  more_ = false;
  for (int writes = 0; writes < kWritesPerTurn; ++writes) {
    if (written() && !(uplink_ && uplink_->take(output_))) return true;
    if (!flush()) return false;
    if (!written()) return true;
  }
  more_ = true;
  return true;
}

bool TcpBridge::flush() {
  while (!written()) {
    const auto rest = std::span(output_).subspan(written_);
    const ssize_t n = ::send(router_.get(), rest.data(), rest.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n < 0) return errno == EAGAIN || errno == EINTR;
    written_ += static_cast<std::size_t>(n);
  }
  output_.clear();
  written_ = 0;
  return true;
}

void TcpBridge::command(std::int8_t type, Address mailbox) {
  constexpr std::uint32_t kSize = kHeaderSize + sizeof(std::uint32_t);
  const Header header{.flags = flag::kNativeOrder, .type = type, .length = kSize};
  const std::size_t at = output_.size();
  output_.resize(at + kSize);
  wire::encode_header(header, wire::HeaderBytes(&output_[at], kHeaderSize));
  wire::HeaderWord::store(&output_[at + kHeaderSize], mailbox.raw(), std::endian::native);
}

// --- from the router

bool TcpBridge::read_router() {
  const std::span<std::byte> room = reader_.room();
  std::array<iovec, 2> pieces{iovec{room.data(), room.size()},
                              iovec{scratch_.data(), scratch_.size()}};
  msghdr message{};
  message.msg_iov = pieces.data() + (room.empty() ? 1 : 0);
  message.msg_iovlen = room.empty() ? 1 : 2;
  const ssize_t n = ::recvmsg(router_.get(), &message, MSG_DONTWAIT);
  if (n == 0) return false;
  if (n < 0) return errno == EAGAIN || errno == EINTR;
  const auto size = static_cast<std::size_t>(n);
  const std::size_t in_room = std::min(size, room.size());
  if (in_room > 0) reader_.advance(in_room);
  return take_messages(std::span(scratch_).first(size - in_room));
}

// False: nobody knows where the next message begins.
bool TcpBridge::take_messages(std::span<std::byte> chunk) {
  for (;;) {
    const wire::StreamReader::Item item = reader_.next(chunk);
    if (item.status == wire::StreamReader::Status::kNeedMore) return true;
    if (item.status != wire::StreamReader::Status::kMessage) return false;
    const auto body = item.message.subspan(kHeaderSize);
    if (item.header.dest == Address() && item.header.src == Address()) {
      on_router_command(item.header, body);
    } else {
      mailboxes_.deliver(item.header, body);
    }
  }
}

void TcpBridge::on_router_command(const Header& header, std::span<const std::byte> body) {
  switch (header.type) {
    case router_command::kLifesign: {
      if (output_.size() > kAnswersBytesMax) return;
      const std::size_t at = output_.size();
      output_.resize(at + kHeaderSize);
      wire::encode_header(wire::reply_to(header, type::kOk),
                          wire::HeaderBytes(&output_[at], kHeaderSize));
      return;
    }
    case router_command::kAddressWidths:
      widths_ = router_command::decode_widths(body).value_or(widths_);
      return;
    case type::kOk:
    case type::kError:
      return on_router_word(header.type == type::kOk);
    default:
      return;  // of another version
  }
}

}  // namespace tims::client
