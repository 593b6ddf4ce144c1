#include "router/io/tcp_path.h"

#include <algorithm>
#include <cerrno>
#include <iterator>
#include <system_error>
#include <utility>

#include <fmt/core.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/socket.h"
#include "router/io/net/addresses.h"

namespace tims::io {
namespace {

using link::NetAddress;

constexpr std::size_t kRoomBytes = 64 << 10;
constexpr Duration kLookEvery = std::chrono::seconds(1);
// What nobody acknowledges for so long is lost, and so is the connection: another path carries the
// link meanwhile, and a new connection is made at once.
constexpr int kUnacknowledgedMs = 4000;
// The less waits in the kernel, the less an urgent message waits there.
constexpr int kPathUnsentBytesMax = 32 << 10;

void set_path_options(int socket) {
  os::set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  os::set_option(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, kPathUnsentBytesMax);
  os::set_option(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, kUnacknowledgedMs);
  os::keep_alive(socket, {.idle_s = 10, .probe_s = 2, .probes = 3});
}

NetAddress over_tcp(NetAddress address) {
  address.kind = link::PathKind::kTcp;
  return address;
}

std::string reason_text(int error) {
  return std::error_code(error, std::generic_category()).message();
}

}  // namespace

TcpPath::TcpPath(Loop& loop, Log& log, Listener& listener)
    : loop_(loop),
      log_(log),
      listener_(listener),
      acceptor_(loop, log, [this](os::File socket, const Visitor&) { accept(std::move(socket)); }),
      room_(kRoomBytes) {}

TcpPath::~TcpPath() = default;

Result<config::Endpoint> TcpPath::listen(const config::Endpoint& where, os::SocketStore* store) {
  auto listening = acceptor_.listen(where, store);
  is_listening_ = listening.ok();
  return listening;
}

// --- connections

void TcpPath::accept(os::File socket) {
  SystemAddress peer;
  if (::getpeername(socket.get(), peer.get(), &peer.size) != 0) return;
  make_room_for_a_stranger();
  add(over_tcp(peer.net_address()), {.socket = std::move(socket), .since = os::now()});
}

void TcpPath::make_room_for_a_stranger() {
  auto oldest = connections_.end();
  std::size_t strangers = 0;
  for (auto one = connections_.begin(); one != connections_.end(); ++one) {
    Connection& connection = one->second;
    if (connection.is_ours || connection.is_linked) continue;
    connection.is_linked = listener_.is_linked(one->first);
    if (connection.is_linked) continue;
    ++strangers;
    if (oldest == connections_.end() || connection.since < oldest->second.since) oldest = one;
  }
  if (strangers >= kStrangersMax) end(oldest, "");
}

TcpPath::Connections::iterator TcpPath::call(Time now, const NetAddress& to) {
  if (!listener_.is_called(to)) return connections_.end();
  Call& call = calls_[to];
  if (now < call.next) return connections_.end();
  call.next = now + kCallAgain;
  SystemAddress address = system_address(to);
  os::File socket(::socket(address.family(), SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const bool begun =
      socket && (::connect(socket.get(), address.get(), address.size) == 0 || errno == EINPROGRESS);
  if (!begun) return connections_.end();
  add(to, {.socket = std::move(socket), .is_ours = true, .is_connecting = true, .since = now});
  return connections_.find(to);
}

void TcpPath::add(const NetAddress& address, Connection connection) {
  if (const auto former = connections_.find(address); former != connections_.end()) end(former, "");
  set_path_options(connection.socket.get());
  connection.queue.reserve(kQueueBytesMax);
  const Interest interest = connection.is_connecting ? Interest::kBoth : Interest::kReading;
  Connection& kept = connections_[address] = std::move(connection);
  kept.watch = std::make_unique<Watch>(
      loop_, kept.socket.get(), [this, address](Ready ready) { on_ready(address, ready); },
      interest);
  if (next_look_ == kNever) next_look_ = kept.since + kLookEvery;
}

void TcpPath::end(Connections::iterator connection, const std::string& why) {
  const NetAddress address = connection->first;
  if (connection->second.is_ours) {
    Call& call = calls_[address];
    if (!why.empty() && why != std::exchange(call.failure, why))
      log_.warning(
          fmt::format("the connection for links to {} has ended: {}", address.to_string(), why));
  }
  connection->second.watch.reset();
  ended_.push_back(std::move(connection->second.arriving));
  connections_.erase(connection);
  listener_.on_tcp_gone(address);
}

// --- bytes

bool TcpPath::offer(const link::Burst& burst) {
  auto found = connections_.find(burst.to);
  if (found == connections_.end()) found = call(os::now(), burst.to);
  if (found == connections_.end()) return true;
  Connection& connection = found->second;
  if (connection.queue.empty()) offered_.push_back(burst.to);
  burst.for_each([&](std::span<const std::byte> datagram) { put(connection, datagram); });
  return true;
}

void TcpPath::put(Connection& connection, std::span<const std::byte> datagram) {
  const std::size_t size = link::DatagramStream::kSizeBytes + datagram.size();
  std::vector<std::byte>& queue = connection.queue;
  if (queue.size() + size > kQueueBytesMax) {
    const auto sent = static_cast<std::ptrdiff_t>(std::exchange(connection.sent, 0));
    queue.erase(queue.begin(), queue.begin() + sent);
  }
  if (queue.size() + size > kQueueBytesMax)
    ++lost_;
  else
    link::DatagramStream::put(datagram, queue);
}

void TcpPath::flush() {
  ended_.clear();
  for (const NetAddress& address : std::exchange(offered_, {})) {
    const auto found = connections_.find(address);
    if (found != connections_.end() && !found->second.is_connecting) write(found->second);
  }
}

// A broken connection is noticed by reading.
void TcpPath::write(Connection& connection) {
  std::vector<std::byte>& queue = connection.queue;
  while (connection.sent < queue.size()) {
    const ssize_t n = ::send(connection.socket.get(), queue.data() + connection.sent,
                             queue.size() - connection.sent, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return connection.watch->set(Interest::kBoth);
    connection.sent += static_cast<std::size_t>(n);
  }
  queue.clear();
  connection.sent = 0;
  connection.watch->set(Interest::kReading);
}

void TcpPath::on_ready(const NetAddress& address, Ready ready) {
  const auto found = connections_.find(address);
  Connection& connection = found->second;
  int error = 0;
  if (connection.is_connecting && ready.to_write) {
    socklen_t size = sizeof error;
    ::getsockopt(connection.socket.get(), SOL_SOCKET, SO_ERROR, &error, &size);
    connection.is_connecting = error != 0;
    if (error == 0) calls_[address].failure.clear();
  }
  std::string why = error == 0 ? std::string() : reason_text(error);
  if (why.empty() && ready.to_write && !connection.is_connecting) write(connection);
  if (why.empty() && ready.to_read && !connection.is_connecting) why = receive(address, connection);
  if (!why.empty()) end(found, why);
  listener_.on_tcp_turn_end();
}

// Why it has ended; empty: it goes on.
std::string TcpPath::receive(const NetAddress& address, Connection& connection) {
  const ssize_t n = ::recv(connection.socket.get(), room_.data(), room_.size(), 0);
  if (n < 0 && (errno == EAGAIN || errno == EINTR)) return {};
  if (n < 0) return reason_text(errno);
  if (n == 0) return "the other side has closed it";
  const bool goes_on = connection.arriving.feed(
      std::span(room_).first(static_cast<std::size_t>(n)),
      [&](std::span<std::byte> datagram) { listener_.on_tcp_datagram(address, datagram); });
  return goes_on ? "" : "what came are no datagrams of a router";
}

// --- time

Time TcpPath::next_timeout() const { return connections_.empty() ? kNever : next_look_; }

bool TcpPath::is_overdue(Time now, const NetAddress& address, Connection& connection,
                         std::string& why) const {
  if (connection.is_connecting && now >= connection.since + kConnectTime) {
    why = "it does not answer";
    return true;
  }
  if (connection.is_ours) return !listener_.is_called(address);
  if (connection.is_linked) return false;
  connection.is_linked = listener_.is_linked(address);
  return !connection.is_linked && now >= connection.since + kStrangerTime;
}

void TcpPath::on_timeout(Time now) {
  if (now < next_look_) return;
  next_look_ = now + kLookEvery;
  for (auto one = connections_.begin(); one != connections_.end();) {
    const auto next = std::next(one);
    std::string why;
    if (is_overdue(now, one->first, one->second, why)) end(one, why);
    one = next;
  }
  std::erase_if(calls_, [this](const auto& call) { return !listener_.is_called(call.first); });
}

}  // namespace tims::io
