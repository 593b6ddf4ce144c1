// Over TCP, as the original's clients do it: to routers elsewhere, and to original routers.
#include <cerrno>
#include <system_error>

#include "client/tcp_client.h"
#include "os/clock.h"
#include "tools/timsctl/connection.h"
#include "tools/timsctl/failure.h"

namespace timsctl {

namespace {

using tims::client::TcpClient;
constexpr std::uint32_t kAnswerMax = 256U << 10;  // of a router to a question, bytes

std::string hint_for(std::string_view why, const TcpHost& host) {
  const auto is = [&](int error) { return why == std::generic_category().message(error); };
  if (is(ECONNREFUSED))
    return "a fresh router listens on loopback only: tcp.listen in its configuration";
  if (is(ETIMEDOUT) || is(EHOSTUNREACH) || is(ENETUNREACH))
    return "is that host up, and its network? A firewall may drop what comes to port " +
           std::to_string(host.port);
  return "that name has no address: is it spelt so? `getent hosts " + host.host + "`";
}

class TcpConnection final : public Connection {
 public:
  TcpConnection(TcpClient client, std::string where, tims::Duration timeout)
      : client_(std::move(client)), where_(std::move(where)), timeout_(timeout) {}

  void begin(const MailboxWish& wish);

  [[nodiscard]] tims::Address address() const override { return address_; }
  [[nodiscard]] tims::AddressWidths widths() const override { return client_.protocol().widths(); }
  [[nodiscard]] std::string where() const override { return where_; }
  [[nodiscard]] int descriptor() const override { return client_.socket().get(); }

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
  [[nodiscard]] Failure failure(const tims::Error& error) const;

  TcpClient client_;
  std::string where_;
  tims::Duration timeout_;
  tims::Address address_{};
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
      .src = src};
  return client_.send(header, body, tims::os::deadline_after(timeout_));
}

tims::Result<Message> TcpConnection::take() {
  auto message = client_.take();
  if (message) return message;
  if (message.error() == tims::Errc::kVersion) throw failure(message.error());
  if (message.error() == tims::Errc::kTooBig)
    return tims::Error(tims::Errc::kTooBig, message.error().detail() + "; see --body-max");
  return message;
}

Failure TcpConnection::failure(const tims::Error& error) const {
  if (error == tims::Errc::kVersion)
    return {Exit::kNoRouter, "no_router", where_ + " answers in HTTP: no router's TCP port",
            "-H takes the address of tcp.listen (port 2000 unless configured), not that of "
            "http.listen"};
  return failure_of(error, where_);
}

void TcpConnection::begin(const MailboxWish& wish) {
  const tims::Time deadline = tims::os::deadline_after(timeout_);
  // A tool that is stopped behind a pager is not dead.
  client_.protocol().put_command(tims::wire::router_command::kDisableWatchdog);
  if (auto heard = client_.log_in(deadline); !heard) throw failure(heard.error());
  for (int taken = 1;; ++taken) {
    address_ = mailbox_address(wish, 0, widths());
    const auto done = client_.register_mailbox(address_, deadline);
    if (done) return;
    if (!(done.error() == tims::Errc::kAddressInUse) || !may_draw_again(wish, taken))
      throw failure(done.error());
  }
}

}  // namespace

std::unique_ptr<Connection> connect_tcp(const TcpHost& host, const MailboxWish& wish,
                                        tims::Duration timeout) {
  const std::uint32_t received_max =
      std::max(wish.body_max, kAnswerMax) + static_cast<std::uint32_t>(tims::kHeaderSize);
  auto client = TcpClient::connect(host, tims::os::deadline_after(timeout), received_max);
  if (!client) {
    const std::string& why = client.error().detail();
    throw Failure(Exit::kNoRouter, "no_router", "no router at " + to_string(host) + ": " + why,
                  hint_for(why, host));
  }
  auto connection = std::make_unique<TcpConnection>(std::move(*client), to_string(host), timeout);
  connection->begin(wish);
  return connection;
}

}  // namespace timsctl
