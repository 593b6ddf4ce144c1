// Through libtims: a session at the router of this host.
#include <array>
#include <atomic>
#include <cerrno>
#include <system_error>

#include <sys/socket.h>
#include <sys/un.h>

#include "os/wakeup.h"
#include "tims/session.h"
#include "tools/timsctl/connection.h"
#include "tools/timsctl/failure.h"

namespace timsctl {

namespace {

// Counted by the session's own thread, which may outlive the connection by a moment.
class Losses {
 public:
  [[nodiscard]] std::uint64_t count() const { return count_; }
  // Readable from a loss until seen().
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
                  std::shared_ptr<Losses> losses)
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
  std::shared_ptr<Losses> losses_;
  tims::os::File descriptor_;
};

// A session would wait for a router to appear; a person wants to know at once that there is none.
void check_socket(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path)
    throw usage_error(path + ": longer than a socket's path can be");
  path.copy(address.sun_path, path.size());
  const tims::os::File socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): the system's own signature
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0)
    return;
  const std::string reason = std::system_category().message(errno);
  if (errno == EACCES || errno == EPERM)
    throw Failure(
        Exit::kDenied, "denied", path + ": " + reason,
        "join the group that owns the socket (`ls -l " + path + "`), or set unix.everybody");
  if (errno == EPROTOTYPE)
    throw Failure(Exit::kNoRouter, "no_router", path + ": this socket is not a router's");
  throw Failure(Exit::kNoRouter, "no_router", "no router at " + path + ": " + reason,
                "start one with `tims-router`, or name another with -H or $TIMS_ROUTER");
}

tims::Mailbox open(tims::Session& session, const MailboxWish& wish, const std::string& path) {
  tims::MailboxOptions options{
      .address = {}, .slots = wish.slots, .body_max = wish.body_max, .event_fd = true};
  const tims::AddressWidths widths = session.address_widths();
  const std::uint32_t system = session.router().fields(widths).system;
  for (int taken = 1;; ++taken) {
    options.address = mailbox_address(wish, system, widths);
    auto mailbox = session.open(options);
    if (mailbox) return std::move(*mailbox);
    const bool in_use = mailbox.error().code() == tims::Errc::kAddressInUse;
    if (!in_use || !may_draw_again(wish, taken)) throw failure_of(mailbox.error(), path);
  }
}

}  // namespace

std::unique_ptr<Connection> connect_local(const UnixHost& host, const MailboxWish& wish,
                                          tims::Duration timeout, Log log) {
  check_socket(host.path);
  tims::SessionOptions options;
  options.name = "timsctl";
  options.router = host.path;
  options.timeout = timeout;
  auto losses = std::make_shared<Losses>();
  options.on_event = [log = std::move(log), losses](const tims::SessionEvent& event) {
    log(event.text);
    if (event.kind == tims::SessionEvent::Kind::kLost) losses->happened();
  };
  auto session = tims::Session::connect(std::move(options));
  if (!session) throw failure_of(session.error(), host.path);
  auto mailbox = open(*session, wish, host.path);
  return std::make_unique<LocalConnection>(std::move(*session), std::move(mailbox), host.path,
                                           std::move(losses));
}

}  // namespace timsctl
