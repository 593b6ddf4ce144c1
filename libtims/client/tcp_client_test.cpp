#include "client/tcp_client.h"

#include <string_view>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/wakeup.h"
#include "tests/support/patience.h"
#include "tests/support/tcp_socket.h"
#include "wire/header.h"

namespace tims::client {
namespace tcp_client_test {

namespace router_command = wire::router_command;

Time soon() { return os::deadline_after(test::kPatience); }

// The peer of a client: sends what a router would send.
class TcpClientTest : public testing::Test {
 protected:
  static constexpr std::uint32_t kReceivedMax = 1 << 20;

  void SetUp() override {
    auto listener = test::listen_tcp();
    ASSERT_TRUE(listener);
    auto client = TcpClient::connect({"127.0.0.1", listener->port}, soon(), kReceivedMax);
    ASSERT_TRUE(client) << client.error().message();
    client_.emplace(*std::move(client));
    ASSERT_TRUE(os::is_ready(listener->socket.get(), POLLIN, soon()));
    router_ = os::File(::accept(listener->socket.get(), nullptr, nullptr));
    ASSERT_TRUE(router_);
  }

  void router_sends(std::span<const std::byte> bytes) {
    ASSERT_EQ(::send(router_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  void router_sends_text(std::string_view text) { router_sends(std::as_bytes(std::span(text))); }
  void router_sends(const Header& header, std::span<const std::byte> body = {}) {
    wire::TcpClientProtocol other(kReceivedMax);
    other.put(header, body);
    router_sends(other.unsent());
  }

  std::optional<TcpClient> client_;
  os::File router_;
};

TEST_F(TcpClientTest, LoggingInLearnsHowTheFleetDividesAddresses) {
  EXPECT_EQ(client_->protocol().widths(), AddressWidths());
  const AddressWidths widths{6, 8, 10, 8};
  router_sends({.type = router_command::kAddressWidths}, router_command::encode_widths(widths));
  router_sends({.type = type::kError});  // no client has the mailbox
  ASSERT_TRUE(client_->log_in(soon()));
  EXPECT_EQ(client_->protocol().widths(), widths);
}

TEST_F(TcpClientTest, NobodyAnswers) {
  const Time now = os::now();
  EXPECT_EQ(client_->log_in(now).error().code(), Errc::kTimeout);
  EXPECT_EQ(client_->receive(now).error().code(), Errc::kTimeout);
  EXPECT_EQ(client_->take().error().code(), Errc::kEmpty);
}

TEST_F(TcpClientTest, WhatComesBeforeAnAnswerWaits) {
  router_sends({.type = -6, .dest = Address(1), .src = Address(2)});
  router_sends({.type = type::kOk});
  router_sends({.type = -7, .dest = Address(1), .src = Address(2)});
  ASSERT_TRUE(client_->delete_mailbox(Address(1), soon()));
  EXPECT_EQ(client_->receive(soon())->header.type, -6);
  EXPECT_EQ(client_->receive(soon())->header.type, -7);
}

TEST_F(TcpClientTest, AServerOfWebPages) {
  router_sends_text("HTTP/1.1 400 Bad Request\r\n\r\n");
  EXPECT_EQ(client_->receive(soon()).error().code(), Errc::kVersion);
  EXPECT_EQ(client_->receive(soon()).error().code(), Errc::kVersion) << "now as before";
}

TEST_F(TcpClientTest, MoreThanItTakes) {
  std::vector<std::byte> bytes(kHeaderSize);
  const Header header{.dest = Address(1), .src = Address(0x03140000), .length = kReceivedMax + 1};
  wire::encode_header(header, wire::HeaderBytes(bytes.data(), kHeaderSize));
  router_sends(bytes);
  const auto received = client_->receive(soon());
  ASSERT_FALSE(received);
  EXPECT_EQ(received.error().code(), Errc::kTooBig);
  EXPECT_NE(received.error().detail().find("Ladar(3/0)"), std::string::npos);
}

// Larger than the socket buffer: the rest is sent before later messages.
TEST_F(TcpClientTest, LargeBodiesArriveWhole) {
  std::vector<std::byte> body(8U << 20);
  for (std::size_t i = 0; i < body.size(); ++i) body[i] = static_cast<std::byte>(i * 7 / 5);
  std::vector<std::byte> arrived(2 * kHeaderSize + body.size());
  std::thread reader([&] {
    EXPECT_EQ(::recv(router_.get(), arrived.data(), arrived.size(), MSG_WAITALL),
              static_cast<ssize_t>(arrived.size()));
  });
  EXPECT_TRUE(client_->send({.type = -6, .dest = Address(1)}, body, soon()));
  EXPECT_TRUE(client_->send({.type = -7, .dest = Address(1)}, {}, soon()));
  reader.join();
  EXPECT_TRUE(std::ranges::equal(std::span(arrived).subspan(kHeaderSize, body.size()), body));
  EXPECT_EQ(static_cast<std::int8_t>(arrived[kHeaderSize + body.size() + 1]), -7);
}

TEST_F(TcpClientTest, TheRouterHasGone) {
  router_sends({.type = -6, .dest = Address(1)});
  router_.reset();
  EXPECT_TRUE(client_->receive(soon())) << "what it sent before";
  EXPECT_EQ(client_->receive(soon()).error().code(), Errc::kClosed);
}

}  // namespace tcp_client_test
}  // namespace tims::client
