#include "router/io/acceptor.h"

#include <cerrno>

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/peer.h"
#include "os/socket.h"

namespace tims::io {
namespace {

constexpr int kBacklog = 4096;
constexpr int kConnectionsPerTurn = 64;
constexpr auto kPause = std::chrono::milliseconds(100);

os::File open_spare() { return os::File(::open("/dev/null", O_RDONLY | O_CLOEXEC)); }

Error cannot_listen(const config::Endpoint& where) {
  const Errc code = errno == EADDRINUSE ? Errc::kAddressInUse : Errc::kSystem;
  return {code, os::system_error(where.to_string()).detail()};
}

}  // namespace

Acceptor::Acceptor(Loop& loop, Log& log, OnConnection on_connection,
                   std::function<void()> on_turned_away)
    : loop_(loop),
      log_(log),
      on_connection_(std::move(on_connection)),
      on_turned_away_(std::move(on_turned_away)),
      pause_(loop, [this] { watch_->set(Interest::kReading); }),
      spare_(open_spare()) {}

Result<config::Endpoint> Acceptor::listen(const config::Endpoint& where, os::SocketStore* store) {
  const auto numeric = numeric_address(where.host, where.port);
  if (!numeric) return Error(Errc::kInvalidArgument, where.to_string() + ": not a numeric address");
  SystemAddress address = system_address(*numeric);
  os::File file = store != nullptr ? store->take(SOCK_STREAM, *address.get()) : os::File();
  if (!file) {
    auto opened = open(where, address);
    if (!opened) return opened.error();
    file = std::move(*opened);
  }
  if (::listen(file.get(), kBacklog) != 0) return cannot_listen(where);
  ::getsockname(file.get(), address.get(), &address.size);
  if (store != nullptr) store->keep(file.get());
  listen(std::move(file));
  return config::Endpoint{where.host, address.net_address().port};
}

Result<os::File> Acceptor::open(const config::Endpoint& where, SystemAddress& address) {
  os::File file(::socket(address.family(), SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!file) return cannot_listen(where);
  const int yes = 1;
  ::setsockopt(file.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  const os::Bound bound = os::bind_even_early(file.get(), address.get(), address.size);
  if (bound == os::Bound::kNo) return cannot_listen(where);
  if (bound == os::Bound::kAddressNotHereYet) log_.warning(waits_for_address("tcp", where));
  return file;
}

void Acceptor::listen(os::File listening) {
  file_ = std::move(listening);
  watch_.emplace(loop_, file_.get(), [this](Ready) { accept(); });
}

void Acceptor::stop() {
  pause_.cancel();
  watch_.reset();
  file_.reset();
}

void Acceptor::accept() {
  const Next next = accept_some();
  if (!file_ || next != Next::kPause) return;
  watch_->set(Interest::kNothing);
  pause_.set(os::now() + kPause);
}

Acceptor::Next Acceptor::accept_some() {
  for (int i = 0; i < kConnectionsPerTurn && file_; ++i) {
    SystemAddress peer;
    os::File file(::accept4(file_.get(), peer.get(), &peer.size, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (file) {
      const bool local = peer.family() == AF_UNIX;
      Visitor visitor{.peer = local ? std::string() : peer.net_address().to_string()};
      if (!local && visitor.is_on_this_host()) visitor.uid = os::loopback_peer_uid(file.get());
      if (gate_ != nullptr)
        gate_->take(std::move(file), std::move(visitor), entrance_, on_connection_);
      else
        on_connection_(std::move(file), std::move(visitor));
    } else if (const Next next = accept_failed(errno); next != Next::kMore) {
      return next;
    }
  }
  return Next::kWait;
}

Acceptor::Next Acceptor::accept_failed(int error) {
  switch (error) {
    case EAGAIN:
      return Next::kWait;
    case EMFILE:
    case ENFILE:
      return turn_one_away();
    case ENOBUFS:
    case ENOMEM:
      log_.warning("no memory for new connections: they must wait");
      return Next::kPause;
    default:
      return Next::kMore;  // this connection broke before it was accepted
  }
}

// The system reports missing descriptors even when no connection is waiting. If a connection
// cannot be accepted even with the spare descriptor, wait: retrying immediately would busy-loop.
Acceptor::Next Acceptor::turn_one_away() {
  spare_.reset();
  os::File newcomer(::accept4(file_.get(), nullptr, nullptr, SOCK_CLOEXEC));
  const bool newcomer_came = static_cast<bool>(newcomer);
  const bool nobody = !newcomer_came && errno == EAGAIN;
  if (newcomer) {
    log_.warning("no free file descriptor: new connections are refused");
    on_turned_away_();
  }
  newcomer.reset();  // first: its descriptor is the only one left for the spare
  spare_ = open_spare();
  if (!spare_ || (!newcomer_came && !nobody)) return Next::kPause;
  return nobody ? Next::kWait : Next::kMore;
}

}  // namespace tims::io
