#include "security/keys/join_server.h"

#include <algorithm>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/epoll.h>
#include <sys/file.h>
#include <sys/socket.h>

#include "base/text.h"
#include "security/keys/bytes.h"

namespace tims::security {
namespace {

constexpr int kBacklog = 64;

// The certificate of the base, with issuing certificate and root behind it: who joins knows only
// the root's fingerprint. Members that renew show theirs.
Result<TlsContext> context_of(const KeyFolder& keys) {
  const auto own = keys.load();
  if (!own) return own.error();
  TlsSettings settings = member_settings(*own, TlsSettings::Side::kServer);
  settings.peer = TlsSettings::PeerCertificate::kOptional;
  settings.chain.insert(settings.chain.end(), own->roots.begin(), own->roots.end());
  return TlsContext::make(std::move(settings));
}

// Held as long as the server exists, also if it is killed.
Result<os::File> lock_of(const KeyFolder& keys) {
  const KeyFolder folder(keys.file("authority"));
  os::File file(
      ::open(folder.file("serving").c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!file) return os::system_error(folder.file("serving"));
  if (::flock(file.get(), LOCK_EX | LOCK_NB) == 0) return file;
  if (errno == EWOULDBLOCK)
    return Error(Errc::kAddressInUse, "timsctl key serve runs already for " + keys.path());
  return os::system_error(folder.file("serving"));
}

// Both families on one socket, or IPv4 only where there is no IPv6.
Result<os::File> listening(std::uint16_t port) {
  for (const int family : {AF_INET6, AF_INET}) {
    os::File socket(::socket(family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
    if (!socket) continue;
    const int on = 1;
    const int off = 0;
    ::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    int bound = -1;
    if (family == AF_INET6) {
      ::setsockopt(socket.get(), IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off);
      sockaddr_in6 any{};
      any.sin6_family = AF_INET6;
      any.sin6_port = htons(port);
      bound = ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&any), sizeof any);
    } else {
      sockaddr_in any{};
      any.sin_family = AF_INET;
      any.sin_port = htons(port);
      bound = ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&any), sizeof any);
    }
    if (bound == 0 && ::listen(socket.get(), kBacklog) == 0) return socket;
    if (errno == EADDRINUSE)
      return Error(Errc::kAddressInUse, fmt::format("TCP port {} is in use", port));
  }
  return os::system_error(fmt::format("cannot listen on TCP port {}", port));
}

std::uint16_t port_of(const os::File& socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  if (::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  return ntohs(address.ss_family == AF_INET6
                   ? reinterpret_cast<const sockaddr_in6*>(&address)->sin6_port
                   : reinterpret_cast<const sockaddr_in*>(&address)->sin_port);
}

std::string numeric(const sockaddr_storage& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  const void* const bytes =
      address.ss_family == AF_INET6
          ? static_cast<const void*>(&reinterpret_cast<const sockaddr_in6*>(&address)->sin6_addr)
          : static_cast<const void*>(&reinterpret_cast<const sockaddr_in*>(&address)->sin_addr);
  if (::inet_ntop(address.ss_family, bytes, text.data(), text.size()) == nullptr) return "?";
  constexpr std::string_view kMapped = "::ffff:";  // IPv4 on a socket of both families
  const std::string_view all = text.data();
  const bool is_mapped = all.starts_with(kMapped) && all.find('.') != std::string_view::npos;
  return std::string(is_mapped ? all.substr(kMapped.size()) : all);
}

}  // namespace

Result<JoinServer> JoinServer::listen(const KeyFolder& keys, std::uint16_t port) {
  if (const auto authority = Authority::open(keys); !authority) return authority.error();
  if (const auto context = context_of(keys); !context) return context.error();
  auto lock = lock_of(keys);
  if (!lock) return lock.error();
  auto listener = listening(port);
  if (!listener) return listener.error();
  os::File epoll(::epoll_create1(EPOLL_CLOEXEC));
  if (!epoll) return os::system_error("epoll");
  epoll_event event{.events = EPOLLIN, .data = {.fd = listener->get()}};
  if (::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, listener->get(), &event) != 0)
    return os::system_error("epoll");
  const std::uint16_t got = port_of(*listener);
  const std::string text = fmt::format("{}\n", got);
  if (::ftruncate(lock->get(), 0) != 0 ||
      ::pwrite(lock->get(), text.data(), text.size(), 0) != static_cast<ssize_t>(text.size()))
    return os::system_error(keys.file("authority/serving"));
  return JoinServer(keys, std::move(*lock), std::move(*listener), std::move(epoll), got);
}

std::optional<std::uint16_t> JoinServer::running(const KeyFolder& keys) {
  const KeyFolder folder(keys.file("authority"));
  const os::File file(::open(folder.file("serving").c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC));
  if (!file || ::flock(file.get(), LOCK_SH | LOCK_NB) == 0) return std::nullopt;
  const auto text = folder.read_secret("serving");
  return text ? base::parse_number<std::uint16_t>(base::trimmed(*text, "\n")) : std::nullopt;
}

Time JoinServer::next_timeout() const {
  Time next = kNever;
  for (const auto& [fd, connection] : connections_) next = std::min(next, connection.ends);
  return next;
}

void JoinServer::watch(const Connection& connection, int operation) const {
  const std::uint32_t events = connection.out.empty() ? EPOLLIN : EPOLLIN | EPOLLOUT;
  epoll_event event{.events = events, .data = {.fd = connection.socket.get()}};
  ::epoll_ctl(epoll_.get(), operation, connection.socket.get(), &event);
}

std::vector<std::string> JoinServer::work(Time now, std::int64_t wall) {
  std::vector<std::string> happened;
  std::erase_if(connections_, [&](const auto& one) { return one.second.ends <= now; });
  std::array<epoll_event, kConnectionsMax + 1> ready{};
  const int count = ::epoll_wait(epoll_.get(), ready.data(), static_cast<int>(ready.size()), 0);
  for (int i = 0; i < count; ++i) {
    const int fd = ready.at(static_cast<std::size_t>(i)).data.fd;
    if (fd == listener_.get()) {
      accept(now, happened);
      continue;
    }
    const auto found = connections_.find(fd);
    if (found == connections_.end()) continue;
    if (serve(found->second, wall, happened))
      watch(found->second, EPOLL_CTL_MOD);
    else
      connections_.erase(found);
  }
  return happened;
}

// A new connection takes the place of the oldest one: who holds connections open keeps nobody out.
void JoinServer::accept(Time now, std::vector<std::string>& events) {
  for (std::size_t i = 0; i < kConnectionsMax; ++i) {
    sockaddr_storage from{};
    socklen_t size = sizeof from;
    os::File socket(::accept4(listener_.get(), reinterpret_cast<sockaddr*>(&from), &size,
                              SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!socket) return;
    const auto context = context_of(keys_);  // timsctl may have changed the keys
    if (!context) {
      events.push_back(context.error().detail());
      return;
    }
    if (connections_.size() >= kConnectionsMax)
      connections_.erase(std::ranges::min_element(connections_, {},
                                                  [](const auto& one) { return one.second.ends; }));
    const int fd = socket.get();
    Connection& added = connections_[fd];
    added.socket = std::move(socket);
    added.source = numeric(from);
    added.tls = std::make_unique<TlsSession>(*context);
    added.ends = now + kConnectionTime;
    watch(added, EPOLL_CTL_ADD);
  }
}

bool JoinServer::receive(Connection& connection) {
  std::array<std::byte, 4096> room{};
  std::size_t total = 0;
  while (total <= 2 * kRequestBytesMax) {
    const ssize_t size = ::recv(connection.socket.get(), room.data(), room.size(), 0);
    if (size < 0) return errno == EAGAIN || errno == EINTR;
    if (size == 0) return false;
    total += static_cast<std::size_t>(size);
    connection.tls->feed(View(room).first(static_cast<std::size_t>(size)));
    while (const std::size_t read = connection.tls->read(room))
      append(connection.request, View(room).first(read));
    if (connection.request.size() > kRequestBytesMax) return false;
  }
  return true;
}

bool JoinServer::flush(Connection& connection) {
  append(connection.out, connection.tls->take(2 << 20));
  while (!connection.out.empty()) {
    const ssize_t size =
        ::send(connection.socket.get(), connection.out.data(), connection.out.size(), MSG_NOSIGNAL);
    if (size < 0) return errno == EAGAIN || errno == EINTR;
    connection.out.erase(connection.out.begin(), connection.out.begin() + size);
  }
  return true;
}

bool JoinServer::serve(Connection& connection, std::int64_t wall,
                       std::vector<std::string>& events) {
  const bool stays = receive(connection);
  const auto state = connection.tls->state();
  if (stays && state == TlsSession::State::kOpen && !connection.answered)
    answer(connection, wall, events);
  if (state == TlsSession::State::kFailed)
    events.push_back(fmt::format("{}: {}", connection.source, connection.tls->error()));
  const bool sent = flush(connection);
  const bool done = state == TlsSession::State::kFailed || state == TlsSession::State::kClosed;
  return stays && sent && !(done && connection.out.empty());
}

void JoinServer::answer(Connection& connection, std::int64_t wall,
                        std::vector<std::string>& events) {
  Reader reader(connection.request);
  const auto size = reader.number<std::uint32_t>();
  if (!reader.ok() || reader.left().size() < size) return;
  connection.answered = true;
  Asker asker{.source = connection.source, .keys = Bytes(32), .proven = {}};
  const auto chain = connection.tls->peer_chain();
  if (!chain.empty()) asker.proven = chain.front();
  JoinAnswer answer;
  const auto request = JoinRequest::parse(reader.take(size));
  if (!request)
    answer.refused = request.error().detail();
  else if (!connection.tls->export_keys(kJoinLabel, {}, asker.keys))
    answer.refused = "the base: TLS gives no keying material";
  else
    answer = desk_.answer(*request, asker, wall);
  events.push_back(fmt::format(
      "{}: {}", connection.source,
      answer.refused.empty() ? "has got its certificate" : "refused: " + answer.refused));
  Bytes framed;
  append_counted<std::uint32_t>(framed, answer.encode());
  if (connection.tls->write(framed)) connection.tls->close();
}

}  // namespace tims::security
