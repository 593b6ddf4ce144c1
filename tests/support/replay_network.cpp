#include "tests/support/replay_network.h"

#include <algorithm>
#include <array>

#include <poll.h>

#include "os/clock.h"
#include "os/wakeup.h"
#include "tests/support/message.h"
#include "tests/support/tcp_socket.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace {

namespace router_command = wire::router_command;

constexpr std::uint32_t kFenceBase = 0x7E000000;
constexpr int kProbe = 0x00FFFFFF;
constexpr std::int8_t kFenceType = -99;  // never answered
constexpr std::int8_t kQuestionType =
    99;  // a command: answered by NOT_AVAILABLE if the mailbox does not exist

Address fence_address(int conn) { return Address(kFenceBase + static_cast<std::uint32_t>(conn)); }

// Recordings do not use this range of addresses.
bool belongs_to_replay(Address a) { return (a.raw() & 0xFF000000) == kFenceBase; }

}  // namespace

Address ReplayConnection::fence_address() const { return test::fence_address(conn); }

ReplayNetwork::ReplayNetwork(const ReplayOptions& options) : options_(options) {}
ReplayNetwork::~ReplayNetwork() = default;

Result<void> ReplayNetwork::use_router(const std::string& endpoint) {
  endpoint_ = endpoint;
  auto socket = connect_tcp(endpoint_, options_.answer_limit);
  if (!socket) return socket.error();
  probe_ = std::make_unique<ReplayConnection>(kProbe, "probe", *std::move(socket));
  register_fence(*probe_);
  if (!fence(*probe_)) {
    return Error(Errc::kTimeout, "a message to itself does not return from " + endpoint_);
  }
  return {};
}

Result<ReplayConnection*> ReplayNetwork::open(int conn, const std::string& peer) {
  auto socket = connect_tcp(endpoint_, options_.answer_limit);
  if (!socket) return socket.error();
  auto& connection = connections_[conn];
  connection = std::make_unique<ReplayConnection>(conn, peer, *std::move(socket));
  register_fence(*connection);
  if (!fence(*connection)) return Error(Errc::kTimeout, "a message to itself does not return");
  return connection.get();
}

ReplayConnection* ReplayNetwork::find(int conn) {
  const auto found = connections_.find(conn);
  return found == connections_.end() ? nullptr : found->second.get();
}

void ReplayNetwork::remove(int conn) { connections_.erase(conn); }

std::vector<ReplayConnection*> ReplayNetwork::all() {
  std::vector<ReplayConnection*> list;
  list.reserve(connections_.size());
  for (auto& [conn, connection] : connections_) list.push_back(connection.get());
  return list;
}

bool ReplayNetwork::send(ReplayConnection& c, std::span<const std::byte> bytes) {
  c.unfenced = true;
  c.socket.send(bytes);
  return run_until([&] { return !c.socket.has_unsent() || !c.socket.is_there(); });
}

void ReplayNetwork::register_fence(ReplayConnection& c) {
  std::array<std::byte, 4> body{};
  for (std::size_t i = 0; i < 4; ++i) {
    body[i] = static_cast<std::byte>(c.fence_address().raw() >> (8 * i));
  }
  Header header{.type = router_command::kMailboxInit};
  header.flags = flag::kBodyLittleEndian;
  c.socket.send(bytes_of(header, body));
  c.unfenced = true;
}

bool ReplayNetwork::fence(ReplayConnection& c) {
  c.socket.send(
      bytes_of({.type = kFenceType, .dest = c.fence_address(), .src = c.fence_address()}));
  ++c.fences_sent;
  c.unfenced = false;
  return run_until([&] { return c.fences_seen == c.fences_sent || !c.socket.is_there(); }) &&
         c.socket.is_there();
}

bool ReplayNetwork::wait_for_gone(int conn) {
  const Time deadline = os::deadline_after(options_.answer_limit);
  while (os::now() < deadline && !stopped_) {
    if (ask_whether_gone(conn)) return true;
  }
  return false;
}

// A command to a mailbox that still exists is not answered; the fence sent after it shows when to
// repeat it.
bool ReplayNetwork::ask_whether_gone(int conn) {
  const Address asked = test::fence_address(conn);
  not_available_ = Address();
  probe_->socket.send(
      bytes_of({.type = kQuestionType, .dest = asked, .src = probe_->fence_address()}));
  return fence(*probe_) && not_available_ == asked;
}

bool ReplayNetwork::run_until(const std::function<bool()>& done) {
  return run_until(done, options_.answer_limit);
}

bool ReplayNetwork::run_until(const std::function<bool()>& done, Duration limit) {
  const Time deadline = os::deadline_after(limit);
  while (!done()) {
    if (stopped_ || os::now() >= deadline) return false;
    run_once(deadline);
  }
  return true;
}

void ReplayNetwork::run_once(Time deadline) {
  std::vector<pollfd> ready = {{options_.stop_fd, POLLIN, 0}};
  std::vector<ReplayConnection*> connections = all();
  if (probe_) connections.push_back(probe_.get());
  std::erase_if(connections, [](auto* c) { return !c->socket.is_there(); });
  for (const ReplayConnection* c : connections) {
    const int events = POLLIN | (c->socket.has_unsent() ? POLLOUT : 0);
    ready.push_back({c->socket.fd(), static_cast<short>(events), 0});
  }
  if (!os::poll_until(ready, deadline)) return;
  if (ready[0].revents != 0) stopped_ = true;
  for (std::size_t i = 0; i < connections.size(); ++i) {
    const short events = ready[i + 1].revents;
    if ((events & POLLOUT) != 0) connections[i]->socket.on_writable();
    if ((events & ~POLLOUT) != 0) on_readable(*connections[i]);
  }
}

void ReplayNetwork::on_readable(ReplayConnection& c) {
  std::vector<OwnedMessage> messages;
  c.socket.on_readable(messages);
  for (OwnedMessage& message : messages) on_message(c, std::move(message));
}

void ReplayNetwork::on_message(ReplayConnection& c, OwnedMessage message) {
  const Header& header = message.header;
  if (is_lifesign(header)) {
    if (!c.answers_lifesigns) return;
    ++lifesigns_answered_;
    c.socket.send(bytes_of(wire::reply_to(header, type::kOk)));
  } else if (belongs_to_replay(header.dest)) {
    if (header.src == header.dest) ++c.fences_seen;
    if (header.type == type::kNotAvailable) not_available_ = header.src;
  } else {
    c.inbox.arrive(std::move(message), line_);
  }
}

}  // namespace tims::test
