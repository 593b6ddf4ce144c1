// Sessions over TCP to a port where no router or a hostile one answers.
#include <array>
#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/wakeup.h"
#include "tests/support/eventually.h"
#include "tests/support/message_socket.h"
#include "tests/support/tcp_client.h"
#include "tests/support/tcp_socket.h"
#include "tims/session.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace tcp_session_hostile_test {

namespace command = wire::router_command;
using namespace std::chrono_literals;

// Answers every command with OK. After a registration of address 1 it sends the bytes given by the
// test, once per connection.
class FakeRouter {
 public:
  explicit FakeRouter(std::vector<std::byte> bytes, bool answers = true)
      : bytes_(std::move(bytes)), answers_(answers) {
    auto listener = listen_tcp();
    EXPECT_TRUE(listener.ok());
    listener_ = std::move(*listener);
    thread_ = std::thread([this] { run(); });
  }
  ~FakeRouter() {
    stopping_ = true;
    ::shutdown(listener_.socket.get(), SHUT_RDWR);
    thread_.join();
  }
  [[nodiscard]] std::string endpoint() const { return listener_.endpoint(); }
  [[nodiscard]] int connections() const { return connections_; }

 private:
  void run() {
    while (!stopping_) {
      os::File file(::accept4(listener_.socket.get(), nullptr, nullptr, SOCK_NONBLOCK));
      if (file) {
        ++connections_;
        serve(MessageSocket(std::move(file)));
      } else {
        os::is_ready(listener_.socket.get(), POLLIN, os::deadline_after(10ms));
      }
    }
  }
  void serve(MessageSocket socket) {
    std::vector<OwnedMessage> messages;
    for (; socket.is_there() && !stopping_; messages.clear()) {
      pollfd wait{socket.fd(), POLLIN, 0};
      if (::poll(&wait, 1, 10) <= 0) continue;
      socket.on_readable(messages);
      for (const OwnedMessage& message : messages) answer(socket, message.header);
    }
  }
  void answer(MessageSocket& socket, const Header& header) {
    if (!answers_ || !is_router_message(header)) return;
    socket.send(bytes_of(Header{.flags = flag::kNativeOrder, .type = type::kOk}));
    if (header.type == command::kMailboxInitWithReply) socket.send(bytes_);
  }

  std::vector<std::byte> bytes_;
  bool answers_;
  Listener listener_;
  std::atomic<bool> stopping_ = false;
  std::atomic<int> connections_ = 0;
  std::thread thread_;
};

std::vector<std::byte> header_with_length(std::uint32_t length) {
  std::vector<std::byte> bytes(kHeaderSize);
  wire::encode_header({.dest = Address(1), .src = Address(2), .length = length},
                      std::span(bytes).first<kHeaderSize>());
  return bytes;
}

Result<Session> connect(const FakeRouter& router, Duration timeout = kPatience) {
  return Session::connect(
      {.router = router.endpoint(), .timeout = timeout, .on_event = [](const SessionEvent&) {}});
}

// The session disconnects from such a router and retries.
void expect_reconnect(std::uint32_t length) {
  FakeRouter router(header_with_length(length));
  auto session = connect(router);
  ASSERT_TRUE(session.ok()) << session.error().message();
  auto mailbox = session->open({.address = Address(1)});
  EXPECT_TRUE(eventually([&] { return router.connections() >= 3; }, "three connections")) << length;
}

TEST(HostileRouter, InvalidLengthsEndTheConnection) {
  for (const std::uint32_t length : {0U, 15U, (16U << 20) + 1, 0xFFFFFFFFU})
    expect_reconnect(length);
}

TEST(HostileRouter, AnswersWithoutARequestAreIgnored) {
  std::vector<std::byte> bytes;
  for (const std::int8_t type : {type::kOk, type::kError, std::int8_t{-100}, std::int8_t{100}})
    for (int i = 0; i < 100; ++i) {
      const auto message = bytes_of(Header{.type = type});
      bytes.insert(bytes.end(), message.begin(), message.end());
    }
  for (const std::uint32_t dest : {0U, 1U, 5U}) {  // 5 has no owner
    const auto message = bytes_of(Header{.dest = Address(dest), .src = Address(9)}, bytes_of("x"));
    bytes.insert(bytes.end(), message.begin(), message.end());
  }
  FakeRouter router(bytes);
  auto session = connect(router);
  ASSERT_TRUE(session.ok()) << session.error().message();
  auto mailbox = session->open({.address = Address(1)});
  ASSERT_TRUE(mailbox.ok()) << mailbox.error().message();
  const auto message = mailbox->peek_for(kPatience);
  ASSERT_TRUE(message.ok());
  EXPECT_EQ(message->header().src, Address(9));
  EXPECT_TRUE(session->connected());
  EXPECT_EQ(router.connections(), 1);
}

TEST(HostileRouter, AServerThatDoesNotAnswerIsNotARouter) {
  FakeRouter router({}, false);
  const auto session = connect(router, 50ms);
  ASSERT_FALSE(session.ok());
  EXPECT_EQ(session.error().code(), Errc::kTimeout);
}

}  // namespace tcp_session_hostile_test
}  // namespace tims::test
