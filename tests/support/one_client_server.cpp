#include "tests/support/one_client_server.h"

#include <array>
#include <system_error>

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include "os/wakeup.h"

namespace tims::test {
namespace {

constexpr auto kLookEvery = std::chrono::milliseconds(5);  // for the end of the test

}  // namespace

OneClientServer::OneClientServer(std::uint16_t port)
    : listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  const int on = 1;
  ::setsockopt(listener_.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_port = htons(port);
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof own;
  if (::bind(listener_.get(), reinterpret_cast<sockaddr*>(&own), size) != 0 ||
      ::listen(listener_.get(), 4) != 0 ||
      ::getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&own), &size) != 0)
    throw std::system_error(errno, std::generic_category(), "server of a test");
  port_ = ntohs(own.sin_port);
}

OneClientServer::~OneClientServer() { stop(); }

void OneClientServer::start() {
  thread_ = std::thread([this] { serve_all(); });
}

void OneClientServer::stop() {
  ends_ = true;
  if (thread_.joinable()) thread_.join();
}

void OneClientServer::serve_all() {
  while (!ends_) {
    if (!os::is_ready(listener_.get(), POLLIN, os::now() + kLookEvery)) continue;
    const os::File client(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
    if (!client) continue;
    ++clients_;
    try {
      serve(client.get());
    } catch (const Gone&) {
      continue;
    }
  }
}

std::string OneClientServer::receive(int client) const {
  if (!os::is_ready(client, POLLIN, os::now() + kLookEvery)) return {};
  std::array<char, 4096> bytes{};
  const ssize_t size = ::recv(client, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return {};
  if (size <= 0) throw Gone();
  return {bytes.data(), static_cast<std::size_t>(size)};
}

void OneClientServer::send(int client, std::string_view bytes) const {
  while (!bytes.empty()) {
    if (ends_) throw Gone();
    const ssize_t sent = ::send(client, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent > 0) bytes.remove_prefix(static_cast<std::size_t>(sent));
    if (sent < 0 && errno != EAGAIN && errno != EINTR) throw Gone();
    if (sent < 0) (void)os::is_ready(client, POLLOUT, os::now() + kLookEvery);
  }
}

}  // namespace tims::test
