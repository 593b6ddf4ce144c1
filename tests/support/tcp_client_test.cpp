#include "tests/support/tcp_client.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "os/wakeup.h"
#include "tests/support/tcp_socket.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace tcp_client_test {

namespace router_command = wire::router_command;
constexpr Duration kShort = std::chrono::milliseconds(1);

// The test is the other end of the client and sends the router's messages explicitly.
class TcpClientTest : public testing::Test {
 protected:
  void SetUp() override {
    auto listener = listen_tcp();
    ASSERT_TRUE(listener);
    auto connected = TcpClient::connect(listener->endpoint());
    ASSERT_TRUE(connected) << connected.error().message();
    client_.emplace(*std::move(connected));
    ASSERT_TRUE(os::is_ready(listener->socket.get(), POLLIN, os::deadline_after(kPatience)));
    router_ = os::File(::accept(listener->socket.get(), nullptr, nullptr));
    ASSERT_TRUE(router_);
  }

  void router_sends(Header header, std::string_view body = {}) {
    std::vector<std::byte> bytes(kHeaderSize);
    header.length = static_cast<std::uint32_t>(kHeaderSize + body.size());
    wire::encode_header(header, wire::HeaderBytes(bytes.data(), kHeaderSize));
    const std::vector<std::byte> body_bytes = bytes_of(body);
    bytes.insert(bytes.end(), body_bytes.begin(), body_bytes.end());
    ASSERT_EQ(::send(router_.get(), bytes.data(), bytes.size(), 0),
              static_cast<ssize_t>(bytes.size()));
  }

  std::vector<std::byte> router_receives(std::size_t size) {
    std::vector<std::byte> bytes(size);
    EXPECT_EQ(::recv(router_.get(), bytes.data(), size, MSG_WAITALL), static_cast<ssize_t>(size));
    return bytes;
  }

  std::optional<TcpClient> client_;
  os::File router_;
};

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> result;
  for (const int v : values) result.push_back(static_cast<std::byte>(v));
  return result;
}

TEST_F(TcpClientTest, SendsInTheRequestedByteOrder) {
  client_->set_byte_order(std::endian::big);
  ASSERT_TRUE(
      client_->send({.type = 5, .dest = Address(0x10), .src = Address(0x20)}, bytes_of("ab")));
  EXPECT_EQ(router_receives(18),
            bytes({0, 5, 0, 0, 0, 0, 0, 0x10, 0, 0, 0, 0x20, 0, 0, 0, 18, 'a', 'b'}));
  client_->set_byte_order(std::endian::little);
  ASSERT_TRUE(client_->send({.type = 5, .dest = Address(0x10), .src = Address(0x20)}));
  EXPECT_EQ(router_receives(16), bytes({3, 5, 0, 0, 0x10, 0, 0, 0, 0x20, 0, 0, 0, 16, 0, 0, 0}));
}

TEST_F(TcpClientTest, RegistersAndKeepsMessagesThatArriveBefore) {
  router_sends({.type = -6, .dest = Address(1), .src = Address(2)}, "data");
  router_sends({.type = type::kOk});
  ASSERT_TRUE(client_->register_mailbox(Address(0x00140001)));
  EXPECT_EQ(router_receives(20), bytes({3, 13, 0,    0, 0, 0, 0, 0, 0, 0, 0, 0, 20, 0, 0, 0,  //
                                        1, 0,  0x14, 0}));
  const auto message = client_->receive();
  ASSERT_TRUE(message);
  EXPECT_EQ(message->body, bytes_of("data"));
}

TEST_F(TcpClientTest, RefusedRegistrationIsAnError) {
  router_sends({.type = type::kError});
  EXPECT_TRUE(client_->register_mailbox(Address(1)).error() == Errc::kAddressInUse);
}

TEST_F(TcpClientTest, AnswersLifesignsWhileItWaits) {
  router_sends({.type = router_command::kLifesign, .seq_nr = 9});
  EXPECT_TRUE(client_->receive(kShort).error() == Errc::kTimeout);
  EXPECT_EQ(client_->lifesigns(), 1U);
  EXPECT_EQ(router_receives(16), bytes({3, 0, 0, 9, 0, 0, 0, 0, 0, 0, 0, 0, 16, 0, 0, 0}));
}

TEST_F(TcpClientTest, CanIgnoreLifesigns) {
  client_->set_answers_lifesigns(false);
  router_sends({.type = router_command::kLifesign});
  EXPECT_TRUE(client_->receive(kShort).error() == Errc::kTimeout);
  EXPECT_EQ(client_->lifesigns(), 1U);
  std::byte b{};
  EXPECT_EQ(::recv(router_.get(), &b, 1, MSG_DONTWAIT), -1);
}

TEST_F(TcpClientTest, ReportsTheCloseAfterTheLastMessage) {
  router_sends({.type = -6, .dest = Address(1)}, "last message");
  router_.reset();
  ASSERT_TRUE(client_->wait_for_close());
  EXPECT_TRUE(client_->receive());
  EXPECT_TRUE(client_->receive().error() == Errc::kClosed);
}

TEST_F(TcpClientTest, AnInvalidHeaderIsAnError) {
  const auto nonsense = bytes({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3});
  ASSERT_EQ(::send(router_.get(), nonsense.data(), nonsense.size(), 0), 16);
  EXPECT_TRUE(client_->receive().error() == Errc::kMalformed);
}

TEST(TcpClient, NoRouter) {
  auto listener = listen_tcp();
  ASSERT_TRUE(listener);
  const std::string endpoint = listener->endpoint();
  listener->socket.reset();
  const auto client = TcpClient::connect(endpoint);
  ASSERT_FALSE(client);
  EXPECT_NE(client.error().message().find(endpoint), std::string::npos);
  EXPECT_TRUE(TcpClient::connect("nonsense").error() == Errc::kInvalidArgument);
}

}  // namespace tcp_client_test
}  // namespace tims::test
