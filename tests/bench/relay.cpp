#include "tests/bench/relay.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <list>
#include <vector>

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include "libtims/wire/header.h"
#include "tests/bench/blocking_socket.h"
#include "tests/support/tcp_socket.h"

namespace tims::bench {
namespace {

constexpr std::size_t kPassedAtOnce = 256 << 10;
// The first messages of a client: a request to disable the watchdog, then its mailbox.
constexpr std::size_t kRegistrationBytes = 2 * kHeaderSize + sizeof(std::uint32_t);

class Relay {
 public:
  explicit Relay(test::Listener listener)
      : listener_(std::move(listener)), poller_(::epoll_create1(EPOLL_CLOEXEC)) {
    watch(listener_.socket, nullptr);
  }

  void run() {
    std::array<epoll_event, 64> events{};
    for (;;) {
      const int n = ::epoll_wait(poller_.get(), events.data(), events.size(), -1);
      for (int i = 0; i < n; ++i) {
        auto* const client = static_cast<Client*>(events[static_cast<std::size_t>(i)].data.ptr);
        if (client == nullptr) {
          accept();
        } else {
          pass(*client);
        }
      }
    }
  }

 private:
  struct Client {
    os::File socket;
    std::uint32_t pair = 0;
    Client* other = nullptr;
  };

  void watch(const os::File& socket, Client* client) {
    epoll_event event{};
    event.events = EPOLLIN;
    event.data.ptr = client;
    ::epoll_ctl(poller_.get(), EPOLL_CTL_ADD, socket.get(), &event);
  }

  // The client has sent only the registration so far, because it waits for the answer.
  void accept() {
    Client client{.socket =
                      os::File(::accept4(listener_.socket.get(), nullptr, nullptr, SOCK_CLOEXEC))};
    const int on = 1;
    ::setsockopt(client.socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    std::array<std::byte, kRegistrationBytes> registration{};
    if (!read_exactly(client.socket, registration)) return;
    std::uint32_t raw = 0;
    std::memcpy(&raw, &registration[registration.size() - sizeof raw], sizeof raw);
    client.pair = Address(raw).fields().instance;
    std::array<std::byte, kHeaderSize> ok{};
    wire::encode_header({.type = type::kOk}, ok);
    if (!write_all(client.socket, ok)) return;
    for (Client& other : clients_) {
      if (other.pair == client.pair) client.other = &other;
    }
    clients_.push_back(std::move(client));
    Client& placed = clients_.back();
    if (placed.other != nullptr) placed.other->other = &placed;
    watch(placed.socket, &placed);
  }

  void pass(Client& from) {
    const ssize_t n = ::recv(from.socket.get(), buffer_.data(), buffer_.size(), MSG_DONTWAIT);
    if (n < 0 && errno == EAGAIN) return;
    if (n <= 0) return remove(from);
    if (from.other == nullptr) return;
    write_all(from.other->socket, std::span(buffer_).first(static_cast<std::size_t>(n)));
  }

  void remove(Client& gone) {
    if (gone.other != nullptr) gone.other->other = nullptr;
    clients_.remove_if([&](const Client& client) { return &client == &gone; });
  }

  test::Listener listener_;
  os::File poller_;
  std::list<Client> clients_;
  std::vector<std::byte> buffer_ = std::vector<std::byte>(kPassedAtOnce);
};

}  // namespace

bool run_relay() {
  auto listener = test::listen_tcp();
  if (!listener) return false;
  std::fprintf(stderr, "listening tcp %s\n", listener->endpoint().c_str());
  Relay(std::move(*listener)).run();
  return true;
}

}  // namespace tims::bench
