#include "tests/support/model_router.h"

#include <algorithm>
#include <list>
#include <map>
#include <optional>
#include <vector>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/wakeup.h"
#include "tests/support/message.h"
#include "tests/support/message_socket.h"
#include "tests/support/tcp_socket.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace {

namespace router_command = wire::router_command;

struct Client {
  explicit Client(os::File file, std::uint32_t length_max) : socket(std::move(file), length_max) {}
  MessageSocket socket;
  bool has_watchdog = true;
  bool owes_lifesign = false;
  bool is_closed = false;
};

std::optional<Address> mailbox_in(const OwnedMessage& message) {
  if (message.body.size() < 4) return std::nullopt;
  const bool little = message.header.body_order() == std::endian::little;
  std::uint32_t raw = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    raw = raw << 8 | std::to_integer<std::uint32_t>(message.body[little ? 3 - i : i]);
  }
  return Address(raw);
}

}  // namespace

class ModelRouter::Loop {
 public:
  Loop(const ModelRouterOptions& options, os::File listener, int stop_fd)
      : options_(options), listener_(std::move(listener)), stop_fd_(stop_fd) {}

  void run();

 private:
  void accept_client();
  void read(Client& client);
  void on_message(Client& client, OwnedMessage message);
  void on_command(Client& client, const OwnedMessage& message);
  void forward(Client& from, Client& to, OwnedMessage message);
  void beat();
  void remove_closed();
  void purge(const Client& client);
  bool has(Fault fault) const { return options_.fault == fault; }

  const ModelRouterOptions options_;
  os::File listener_;
  int stop_fd_;
  std::list<Client> clients_;
  std::map<Address, Client*> table_;
  bool fault_is_over_ = false;
  struct HeldBack {
    Client* to = nullptr;
    OwnedMessage message;
  } held_back_;
};

ModelRouter::ModelRouter(const ModelRouterOptions& options) {
  auto listener = listen_tcp();
  auto stop = os::make_event_fd();
  if (!listener || !stop) return;  // no client can connect
  endpoint_ = listener->endpoint();
  stop_ = *std::move(stop);
  loop_ = std::make_unique<Loop>(options, std::move(listener->socket), stop_.get());
  thread_ = std::thread([this] { loop_->run(); });
}

ModelRouter::~ModelRouter() {
  if (!thread_.joinable()) return;
  os::signal_event_fd(stop_.get());
  thread_.join();
}

void ModelRouter::Loop::run() {
  Time next_beat = os::now() + options_.beat;
  for (;;) {
    std::vector<pollfd> ready = {{stop_fd_, POLLIN, 0}, {listener_.get(), POLLIN, 0}};
    for (const Client& c : clients_) {
      const int events = POLLIN | (c.socket.has_unsent() ? POLLOUT : 0);
      ready.push_back({c.is_closed ? -1 : c.socket.fd(), static_cast<short>(events), 0});
    }
    (void)os::poll_until(ready, next_beat);
    if (ready[0].revents != 0) return;
    std::size_t i = 2;
    for (Client& c : clients_) {
      const short events = ready[i++].revents;
      if ((events & POLLOUT) != 0) c.socket.on_writable();
      if ((events & ~POLLOUT) != 0) read(c);
    }
    remove_closed();
    if (ready[1].revents != 0) accept_client();
    if (os::now() < next_beat) continue;
    beat();
    next_beat += options_.beat;
  }
}

void ModelRouter::Loop::accept_client() {
  os::File file(::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
  const bool any_length = has(Fault::kKeepsTooLongMessages);
  if (!file) return;
  const int on = 1;
  ::setsockopt(file.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  clients_.emplace_back(std::move(file), any_length ? ~0U : options_.message_max);
}

void ModelRouter::Loop::read(Client& client) {
  std::vector<OwnedMessage> messages;
  client.socket.on_readable(messages);
  for (OwnedMessage& message : messages) on_message(client, std::move(message));
  if (!client.socket.is_there()) client.is_closed = true;
}

void ModelRouter::Loop::on_message(Client& client, OwnedMessage message) {
  if (is_router_message(message.header)) return on_command(client, message);
  const auto found = table_.find(message.header.dest);
  if (found != table_.end()) return forward(client, *found->second, std::move(message));
  if (message.header.type <= 0 && !has(Fault::kAnswersReplies)) return;
  const Header answer = wire::reply_to(message.header, type::kNotAvailable);
  client.socket.send(bytes_of(answer));
}

void ModelRouter::Loop::on_command(Client& client, const OwnedMessage& message) {
  const auto answer = [&](std::int8_t type) {
    client.socket.send(bytes_of(wire::reply_to(message.header, type)));
  };
  const auto mailbox = mailbox_in(message);
  switch (message.header.type) {
    case type::kOk:
      client.owes_lifesign = false;
      break;
    case router_command::kMailboxInit:
      if (mailbox) table_.try_emplace(*mailbox, &client);
      break;
    case router_command::kMailboxInitWithReply:
      if (mailbox) {
        const bool is_new = table_.try_emplace(*mailbox, &client).second;
        answer(is_new || has(Fault::kRegistersTwice) ? type::kOk : type::kError);
      }
      break;
    case router_command::kMailboxDelete:
      if (mailbox) table_.erase(*mailbox);
      break;
    case router_command::kMailboxDeleteWithReply:
      if (mailbox) {
        table_.erase(*mailbox);
        answer(type::kOk);
      }
      break;
    case router_command::kMailboxPurge:
      purge(client);
      break;
    case router_command::kEnableWatchdog:
    case router_command::kDisableWatchdog:
      client.has_watchdog = message.header.type == router_command::kEnableWatchdog;
      client.owes_lifesign = false;
      break;
    default:
      break;
  }
}

void ModelRouter::Loop::forward(Client& from, Client& to, OwnedMessage message) {
  const bool befallen = !fault_is_over_ && options_.befalls(message.header);
  if (befallen) fault_is_over_ = true;
  const auto happens = [&](Fault fault) { return befallen && has(fault); };
  if (happens(Fault::kLosesMessage)) return;
  if (happens(Fault::kAltersBody)) message.body.at(0) ^= std::byte{1};
  if (happens(Fault::kAltersPriority)) ++message.header.priority;
  if (happens(Fault::kHangsUp)) from.is_closed = true;
  if (happens(Fault::kRepeatsMessage)) to.socket.send(bytes_of(message.header, message.body));
  if (happens(Fault::kSwapsMessages)) {
    held_back_ = {&to, std::move(message)};
    return;
  }
  to.socket.send(bytes_of(message.header, message.body));
  if (held_back_.to != &to) return;
  to.socket.send(bytes_of(held_back_.message.header, held_back_.message.body));
  held_back_.to = nullptr;
}

void ModelRouter::Loop::beat() {
  for (Client& c : clients_) {
    if (!c.has_watchdog || has(Fault::kNeverClosesSilent)) continue;
    if (c.owes_lifesign) c.is_closed = true;
    c.owes_lifesign = true;
    c.socket.send(bytes_of({.type = router_command::kLifesign}));
  }
  remove_closed();
}

void ModelRouter::Loop::remove_closed() {
  std::erase_if(clients_, [&](Client& c) {
    if (!c.is_closed) return false;
    if (has(Fault::kKeepsMailboxes)) {  // and the client to which they belong
      c.socket.shut_down_sending();
      return false;
    }
    purge(c);
    return true;
  });
}

void ModelRouter::Loop::purge(const Client& client) {
  std::erase_if(table_, [&](const auto& entry) { return entry.second == &client; });
}

}  // namespace tims::test
