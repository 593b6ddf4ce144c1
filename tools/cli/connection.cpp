#include "tools/cli/connection.h"

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <random>
#include <system_error>

#include <poll.h>
#include <sys/signalfd.h>

#include "os/clock.h"
#include "os/environment.h"
#include "os/socket.h"
#include "os/wakeup.h"
#include "tims/session.h"
#include "tools/cli/arguments.h"
#include "tools/cli/failure.h"

namespace timsctl {

Signals::Signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, number);
  ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
  // A closed reader must be an error of write(), not a signal that ends the process without
  // cleanup.
  std::signal(SIGPIPE, SIG_IGN);
  file_ = tims::os::File(::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK));
}

Signals::WaitResult Signals::wait(int fd, tims::Time deadline) const {
  std::array<pollfd, 2> waits{{{file_.get(), POLLIN, 0}, {fd, POLLIN, 0}}};
  const bool ready = tims::os::poll_until(waits, deadline);
  if (waits[0].revents != 0) throw Interrupted();
  return ready ? WaitResult::kReadable : WaitResult::kTimeout;
}

void Signals::forget() const {
  signalfd_siginfo come{};
  while (::read(file_.get(), &come, sizeof come) == sizeof come) {
  }
}

tims::Address mailbox_address(const MailboxRequest& request, std::uint32_t system,
                              const tims::AddressWidths& widths) {
  if (!request.address.empty()) return need_address(request.address, widths);
  std::random_device random;
  return tims::Address::of({.system = system,
                            .class_id = tims::class_id::kTool,
                            .instance = random(),
                            .local = random()},
                           widths);
}

bool may_draw_again(const MailboxRequest& request, int taken) {
  constexpr int kTries = 16;
  return request.address.empty() && taken < kTries;
}

std::optional<Message> receive(Connection& connection, const Signals& signals, tims::Time deadline,
                               std::optional<std::uint64_t> losses) {
  for (;;) {
    auto message = connection.take();
    if (message) return std::move(*message);
    if (message.error().code() != tims::Errc::kEmpty)
      throw failure_of(message.error(), connection.where());
    if (losses && connection.losses() != *losses)
      throw failure_of({tims::Errc::kNoRouter, "the router has disconnected"}, connection.where());
    if (signals.wait(connection.descriptor(), deadline) == Signals::WaitResult::kTimeout &&
        tims::os::now() >= deadline)
      return std::nullopt;
  }
}

Host parse_host(std::string_view text) {
  auto host = tims::wire::parse_endpoint(text);
  if (!host) throw usage_error(host.error().detail());
  return std::move(*host);
}

Host host_of(std::string_view option) {
  std::string host(option);
  if (host.empty()) host = tims::os::environment("TIMS_HOST");
  return parse_host(host.empty() ? tims::default_router() : host);
}

// --- Through libtims: a session at the router of this host.

namespace {

// Counted by the thread of the session, which may end shortly after the connection.
class LossCounter {
 public:
  [[nodiscard]] std::uint64_t count() const { return count_; }
  // Readable after a loss until seen() is called.
  [[nodiscard]] int descriptor() const { return event_.get(); }
  void seen() const { tims::os::drain_event_fd(event_.get()); }
  void happened() {
    ++count_;
    tims::os::signal_event_fd(event_.get());
  }

 private:
  std::atomic<std::uint64_t> count_ = 0;
  tims::os::File event_ = std::move(*tims::os::make_event_fd());
};

class LocalConnection final : public Connection {
 public:
  LocalConnection(tims::Session session, tims::Mailbox mailbox, std::string path,
                  std::shared_ptr<LossCounter> losses)
      : session_(std::move(session)),
        mailbox_(std::move(mailbox)),
        path_(std::move(path)),
        losses_(std::move(losses)),
        descriptor_(
            value_or_fail(tims::os::any_of(std::array{mailbox_.event_fd(), losses_->descriptor()}),
                          "this host")) {}

  [[nodiscard]] tims::Address address() const override { return mailbox_.address(); }
  [[nodiscard]] tims::AddressWidths widths() const override { return session_.address_widths(); }
  [[nodiscard]] std::string where() const override { return path_; }
  [[nodiscard]] std::uint64_t losses() const override { return losses_->count(); }
  [[nodiscard]] int descriptor() const override { return descriptor_.get(); }

  [[nodiscard]] std::uint64_t missed() const override {
    const tims::MailboxCounters counters = mailbox_.counters();
    return counters.replaced + counters.refused + counters.too_big;
  }

  tims::Result<void> send(const tims::Envelope& envelope,
                          std::span<const std::byte> body) override {
    return mailbox_.send(envelope, body);
  }
  tims::Result<void> send_to_router(tims::Envelope envelope,
                                    std::span<const std::byte> body) override {
    envelope.dest = session_.router();
    return mailbox_.send(envelope, body);
  }
  tims::Result<Message> take() override {
    auto guard = mailbox_.try_peek();
    if (!guard) {
      losses_->seen();
      return guard.error();
    }
    return Message{guard->header(), {guard->body().begin(), guard->body().end()}};
  }

 private:
  tims::Session session_;
  tims::Mailbox mailbox_;
  std::string path_;
  std::shared_ptr<LossCounter> losses_;
  tims::os::File descriptor_;
};

// A session would wait for a router; a user needs the error at once.
void check_socket(const std::string& path) {
  const auto socket = tims::os::connect_unix(path);
  if (socket) return;
  if (socket.error() == tims::Errc::kInvalidArgument) throw usage_error(socket.error().detail());
  const std::string reason = std::system_category().message(errno);
  if (errno == EACCES || errno == EPERM)
    throw Failure(Exit::kDenied, "denied", path + ": " + reason,
                  "join the group that owns the socket (`ls -l " + path +
                      "`; `adduser YOU tims` as root, then log in again), or set unix.everybody");
  if (errno == EPROTOTYPE)
    throw Failure(Exit::kNoRouter, "no_router", path + ": this is not the socket of a router");
  throw Failure(Exit::kNoRouter, "no_router", "no router at " + path + ": " + reason,
                "start one with `tims-router`, or name another with -H or $TIMS_ROUTER");
}

tims::Mailbox open(tims::Session& session, const MailboxRequest& request, const std::string& path) {
  tims::MailboxOptions options{
      .address = {}, .slots = request.slots, .body_max = request.body_max, .event_fd = true};
  const tims::AddressWidths widths = session.address_widths();
  const std::uint32_t system = session.router().fields(widths).system;
  for (int taken = 1;; ++taken) {
    options.address = mailbox_address(request, system, widths);
    auto mailbox = session.open(options);
    if (mailbox) return std::move(*mailbox);
    const bool in_use = mailbox.error().code() == tims::Errc::kAddressInUse;
    if (!in_use || !may_draw_again(request, taken)) throw failure_of(mailbox.error(), path);
  }
}

// --- over TCP, as the original's clients do it: to routers elsewhere, and to original routers

using tims::client::TcpClient;
constexpr std::uint32_t kConnectionAnswerMax = 256U << 10;  // largest answer of a router, bytes

std::string hint_for(std::string_view why, const TcpHost& host) {
  const auto is = [&](int error) { return why == std::generic_category().message(error); };
  if (is(ECONNREFUSED))
    return "by default a router listens only on loopback; set tcp.listen in its configuration";
  if (is(ETIMEDOUT) || is(EHOSTUNREACH) || is(ENETUNREACH))
    return "is the host up, and its network? A firewall may block port " +
           std::to_string(host.port);
  return "the name has no address: is it spelled correctly? `getent hosts " + host.host + "`";
}

class TcpConnection final : public Connection {
 public:
  TcpConnection(TcpClient client, std::string where, tims::Duration timeout)
      : client_(std::move(client)), where_(std::move(where)), timeout_(timeout) {}

  void begin(const MailboxRequest& request) {
    const tims::Time deadline = tims::os::deadline_after(timeout_);
    // A tool that waits for a pager must not time out.
    client_.protocol().put_command(tims::wire::router_command::kDisableWatchdog);
    if (auto confirmed = client_.log_in(deadline); !confirmed) throw failure(confirmed.error());
    for (int taken = 1;; ++taken) {
      address_ = mailbox_address(request, 0, widths());
      const auto done = client_.register_mailbox(address_, deadline);
      if (done) return;
      if (!(done.error() == tims::Errc::kAddressInUse) || !may_draw_again(request, taken))
        throw failure(done.error());
    }
  }

  [[nodiscard]] tims::Address address() const override { return address_; }
  [[nodiscard]] tims::AddressWidths widths() const override { return client_.protocol().widths(); }
  [[nodiscard]] std::string where() const override { return where_; }
  [[nodiscard]] int descriptor() const override { return client_.socket().get(); }

  // The router counts the messages that it drops for a slow reader.
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

  tims::Result<Message> take() override {
    auto message = client_.take();
    if (message) return message;
    if (message.error() == tims::Errc::kVersion) throw failure(message.error());
    if (message.error() == tims::Errc::kTooBig)
      return tims::Error(tims::Errc::kTooBig, message.error().detail() + "; see --body-max");
    return message;
  }

 private:
  tims::Result<void> write(const tims::Envelope& envelope, tims::Address src,
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

  [[nodiscard]] Failure failure(const tims::Error& error) const {
    if (error == tims::Errc::kVersion)
      return {Exit::kNoRouter, "no_router",
              where_ + " answers in HTTP: it is not the TCP port of a router",
              "-H requires the address of tcp.listen (default port 2000), not that of "
              "http.listen"};
    return failure_of(error, where_);
  }

  TcpClient client_;
  std::string where_;
  tims::Duration timeout_;
  tims::Address address_{};
};

}  // namespace

std::unique_ptr<Connection> connect_local(const UnixHost& host, const MailboxRequest& request,
                                          tims::Duration timeout, Log log) {
  check_socket(host.path);
  tims::SessionOptions options;
  options.name = "timsctl";
  options.router = host.path;
  options.timeout = timeout;
  auto losses = std::make_shared<LossCounter>();
  options.on_event = [log = std::move(log), losses](const tims::SessionEvent& event) {
    log(event.text);
    if (event.kind == tims::SessionEvent::Kind::kLost) losses->happened();
  };
  auto session = tims::Session::connect(std::move(options));
  if (!session) throw failure_of(session.error(), host.path);
  auto mailbox = open(*session, request, host.path);
  return std::make_unique<LocalConnection>(std::move(*session), std::move(mailbox), host.path,
                                           std::move(losses));
}

namespace {

std::unique_ptr<Connection> connect_tcp(const TcpHost& host, const MailboxRequest& request,
                                        tims::Duration timeout) {
  const std::uint32_t received_max = std::max(request.body_max, kConnectionAnswerMax) +
                                     static_cast<std::uint32_t>(tims::kHeaderSize);
  auto client = TcpClient::connect(host, tims::os::deadline_after(timeout), received_max);
  if (!client) {
    const std::string& why = client.error().detail();
    throw Failure(Exit::kNoRouter, "no_router", "no router at " + to_string(host) + ": " + why,
                  hint_for(why, host));
  }
  auto connection = std::make_unique<TcpConnection>(std::move(*client), to_string(host), timeout);
  connection->begin(request);
  return connection;
}

}  // namespace

std::unique_ptr<Connection> connect(const Host& host, const MailboxRequest& request,
                                    tims::Duration timeout, Log log) {
  if (const auto* tcp = std::get_if<TcpHost>(&host)) return connect_tcp(*tcp, request, timeout);
  return connect_local(std::get<UnixHost>(host), request, timeout, std::move(log));
}

Message ask(Connection& connection, const Signals& signals, tims::Address component,
            std::int8_t type, std::span<const std::byte> body, tims::Duration timeout) {
  const std::string name = component.to_string(connection.widths());
  const std::uint8_t seq_nr = connection.next_seq_nr();
  const std::uint64_t losses = connection.losses();
  value_or_fail(
      connection.send({.dest = component, .type = type, .seq_nr = seq_nr, .report_reason = true},
                      body),
      name);
  const tims::Time deadline = tims::os::deadline_after(timeout);
  while (auto message = receive(connection, signals, deadline, losses)) {
    if (message->header.src != component || message->header.seq_nr != seq_nr) continue;
    if (message->header.type == tims::type::kNotAvailable)
      throw no_such_mailbox(name,
                            "`timsctl component list` shows all; where a rule denies it, `timsctl "
                            "acl log` says so");
    return std::move(*message);
  }
  throw Failure(Exit::kTimeout, "timeout", name + " did not answer",
                "try a longer --timeout; `timsctl explain` shows whether it can be reached");
}

}  // namespace timsctl
