// Over TCP, as the original's clients do it: to routers elsewhere, and to original routers.
#include <algorithm>
#include <deque>

#include "os/clock.h"
#include "tools/timsctl/admin_client.h"
#include "tools/timsctl/connection.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/tcp_socket.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace timsctl {

namespace {

namespace command = tims::wire::router_command;
constexpr std::uint8_t kBodyOrder = tims::flag::kNativeOrder & tims::flag::kBodyLittleEndian;
constexpr std::uint32_t kAnswerMax = 256U << 10;  // of a router to a question, bytes

class TcpConnection final : public Connection {
 public:
  TcpConnection(TcpSocket socket, std::string where, std::uint32_t body_max, tims::Duration timeout)
      : socket_(std::move(socket)),
        where_(std::move(where)),
        reader_(std::max(body_max, kAnswerMax) + static_cast<std::uint32_t>(tims::kHeaderSize)),
        timeout_(timeout) {}

  void begin(const MailboxWish& wish);

  [[nodiscard]] tims::Address address() const override { return address_; }
  [[nodiscard]] tims::AddressWidths widths() const override { return widths_; }
  [[nodiscard]] std::string where() const override { return where_; }
  [[nodiscard]] int descriptor() const override { return socket_.descriptor(); }

  // What the router drops for a slow reader, it counts.
  [[nodiscard]] std::uint64_t missed() const override { return 0; }

  tims::Result<void> send(const tims::Envelope& envelope,
                          std::span<const std::byte> body) override {
    return write(envelope, address_, body);
  }
  tims::Result<void> send_to_router(tims::Envelope envelope,
                                    std::span<const std::byte> body) override {
    envelope.dest = {};
    return write(envelope, tims::Address(), body);
  }
  tims::Result<Message> take() override;

 private:
  tims::Result<void> write(const tims::Envelope& envelope, tims::Address src,
                           std::span<const std::byte> body);
  tims::Result<void> read();
  void sort_in(const tims::wire::StreamReader::Item& item);
  void learn_widths(tims::Time deadline);
  void register_mailbox(const MailboxWish& wish, tims::Time deadline);
  void send_command(std::int8_t type, tims::Address mailbox);
  Message router_says(tims::Time deadline);

  TcpSocket socket_;
  std::string where_;
  tims::wire::StreamReader reader_;
  tims::Duration timeout_;
  bool heard_ = false;
  tims::Address address_{};
  tims::AddressWidths widths_{};
  std::deque<Message> received_;
};

tims::Result<void> TcpConnection::write(const tims::Envelope& envelope, tims::Address src,
                                        std::span<const std::byte> body) {
  const std::uint8_t stream = envelope.stream ? tims::flag::kStream : 0;
  const std::uint8_t trace = envelope.trace ? tims::flag::kTrace : 0;
  const tims::Header header{
      .flags = static_cast<std::uint8_t>(envelope.body_order | stream | trace),
      .type = envelope.type,
      .priority = envelope.priority.value_or(0),
      .seq_nr = envelope.seq_nr,
      .dest = envelope.dest,
      .src = src,
      .length = static_cast<std::uint32_t>(tims::kHeaderSize + body.size())};
  std::vector<std::byte> bytes(header.length);
  tims::wire::encode_header(header, std::span(bytes).first<tims::kHeaderSize>());
  std::ranges::copy(body, bytes.begin() + tims::kHeaderSize);
  return socket_.write_all(bytes, tims::os::deadline_after(timeout_));
}

tims::Result<Message> TcpConnection::take() {
  if (received_.empty())
    if (auto read_ok = read(); !read_ok) return read_ok.error();
  if (received_.empty()) return tims::Errc::kEmpty;
  Message message = std::move(received_.front());
  received_.pop_front();
  return message;
}

// One chunk of the socket.
tims::Result<void> TcpConnection::read() {
  std::vector<std::byte> buffer(64 << 10);
  auto size = socket_.read_some(buffer);
  if (!size) return size.error();
  auto chunk = std::span(buffer).first(*size);
  constexpr std::string_view kHttp = "HTTP/";
  const auto front = chunk.first(std::min(chunk.size(), kHttp.size()));
  if (!heard_ && std::ranges::equal(front, std::as_bytes(std::span(kHttp))))
    throw Failure(Exit::kNoRouter, "no_router", where_ + " answers in HTTP: no router's TCP port",
                  "-H takes the address of tcp.listen (port 2000 unless configured), not that of "
                  "http.listen");
  heard_ = true;
  for (;;) {
    const auto item = reader_.next(chunk);
    switch (item.status) {
      case tims::wire::StreamReader::Status::kNeedMore:
        return {};
      case tims::wire::StreamReader::Status::kMessage:
        sort_in(item);
        break;
      default:
        return tims::Error(tims::Errc::kTooBig,
                           "a message of " + std::to_string(item.header.length) + " bytes from " +
                               item.header.src.to_string(widths_) + "; see --body-max");
    }
  }
}

void TcpConnection::sort_in(const tims::wire::StreamReader::Item& item) {
  const bool from_router = item.header.dest.raw() == 0 && item.header.src.raw() == 0;
  if (from_router && item.header.type == command::kLifesign) {
    (void)write({.dest = {},
                 .type = tims::type::kOk,
                 .priority = item.header.priority,
                 .seq_nr = item.header.seq_nr},
                {}, {});
    return;
  }
  const auto body = item.message.subspan(tims::kHeaderSize);
  received_.push_back({item.header, {body.begin(), body.end()}});
}

void TcpConnection::begin(const MailboxWish& wish) {
  const tims::Time deadline = tims::os::deadline_after(timeout_);
  // A tool that is stopped behind a pager is not dead.
  value_or_fail(write({.dest = {}, .type = command::kDisableWatchdog}, {}, {}), where_);
  learn_widths(deadline);
  register_mailbox(wish, deadline);
}

// An original router, which has the usual ones, does not answer the question.
void TcpConnection::learn_widths(tims::Time deadline) {
  send_command(command::kLogin, {});
  send_command(command::kMailboxDeleteWithReply, {});  // which nobody has
  const Message said = router_says(deadline);
  if (said.header.type != command::kAddressWidths) return;
  widths_ = command::decode_widths(said.body).value_or(widths_);
  (void)router_says(deadline);
}

void TcpConnection::register_mailbox(const MailboxWish& wish, tims::Time deadline) {
  for (int taken = 1;; ++taken) {
    address_ = mailbox_address(wish, 0, widths_);
    send_command(command::kMailboxInitWithReply, address_);
    if (router_says(deadline).header.type == tims::type::kOk) return;
    if (!may_draw_again(wish, taken))
      throw failure_of({tims::Errc::kAddressInUse, address_.to_string(widths_)}, where_);
  }
}

void TcpConnection::send_command(std::int8_t type, tims::Address mailbox) {
  const std::uint32_t raw = mailbox.raw();
  value_or_fail(write({.dest = {}, .type = type, .body_order = kBodyOrder}, {},
                      std::as_bytes(std::span(&raw, 1))),
                where_);
}

// Its next word.
Message TcpConnection::router_says(tims::Time deadline) {
  for (;;) {
    auto message = take();
    if (message && message->header.dest.raw() == 0) return std::move(*message);
    if (message) continue;
    if (message.error().code() != tims::Errc::kEmpty) throw failure_of(message.error(), where_);
    if (!socket_.wait_readable(deadline)) throw failure_of(tims::Errc::kTimeout, where_);
  }
}

}  // namespace

std::unique_ptr<Connection> connect_tcp(const TcpHost& host, const MailboxWish& wish,
                                        tims::Duration timeout) {
  auto connection = std::make_unique<TcpConnection>(TcpSocket::connect(host, timeout),
                                                    to_string(host), wish.body_max, timeout);
  connection->begin(wish);
  return connection;
}

}  // namespace timsctl
