// A client that stops reading: it does not block others, and never receives an incomplete message.
#include <algorithm>
#include <csignal>

#include "tests/support/eventually.h"
#include "tests/system/tcp_fixture.h"

namespace tims::test {
namespace tcp_slow_reader_test {

constexpr Address kSlow{0x00140000};
constexpr Address kSource{0x00150000};
constexpr Address kPing{0x00160000};
constexpr Address kPong{0x00170000};
constexpr std::uint32_t kEnd = 0xFFFFFFFF;

// A body that contains its number and shows whether it is complete.
std::vector<std::byte> numbered(std::uint32_t number, std::size_t size) {
  std::vector<std::byte> body(size);
  for (std::size_t i = 0; i < size; ++i) {
    body[i] = static_cast<std::byte>(number >> 8 * (i % 4));
  }
  return body;
}

// The number, or kEnd for an incomplete body.
std::uint32_t number_of(const std::vector<std::byte>& body) {
  std::uint32_t number = 0;
  for (std::size_t i = 0; i < 4; ++i) number |= std::to_integer<std::uint32_t>(body[i]) << 8 * i;
  return body == numbered(number, body.size()) ? number : kEnd;
}

class SlowReaderTest : public TcpTest {
 protected:
  static constexpr std::size_t kBody = 10'000;
  static constexpr std::uint32_t kCount = 2000;  // far more than sockets and queue hold

  void SetUp() override {
    start({"tcp.queue=1MiB", "message.max=64KiB"});
    slow_.emplace(connect_with(kSlow));
    source_.emplace(connect());
  }
  void flood(std::uint8_t priority) {
    for (std::uint32_t i = 0; i < kCount; ++i) {
      ASSERT_TRUE(source_
                      ->send({.type = -6, .priority = priority, .dest = kSlow, .src = kSource},
                             numbered(i, kBody))
                      .ok());
    }
    ASSERT_TRUE(is_served(*source_));
  }

  std::optional<TcpClient> slow_;
  std::optional<TcpClient> source_;
};

TEST_F(SlowReaderTest, UnreadMessagesAreCountedWhenItDisconnects) {
  flood(1);
  slow_->close();
  EXPECT_TRUE(eventually(
      [&] { return ask(*source_, R"({"ask":"stats"})").find("client_gone") != std::string::npos; },
      "the loss is counted"));
}

TEST_F(SlowReaderTest, WaitingMessagesAreWrittenBeforeTheRouterExits) {
  flood(1);
  router_->process().signal(SIGTERM);
  std::uint32_t last = kEnd;
  while (const auto message = slow_->receive()) {
    last = number_of(message->body);
    ASSERT_NE(last, kEnd) << "an incomplete message";
  }
  EXPECT_EQ(last, kCount - 1);
  const auto status = router_->process().wait();
  ASSERT_TRUE(status.ok()) << status.error().message();
  EXPECT_TRUE(status->success()) << status->to_string();
}

TEST_F(SlowReaderTest, DoesNotPreventTheRouterFromExiting) {
  flood(1);
  const auto status = router_->stop();
  ASSERT_TRUE(status.ok()) << status.error().message();
  EXPECT_TRUE(status->success()) << status->to_string();
}

// Twenty stalled readers exceed the memory of all queues; a client that reads stays connected and
// gets messages of high priority.
TEST_F(TcpTest, StalledReadersDoNotAffectAClientThatReads) {
  start({"message.max=1MiB", "tcp.queue=16MiB"});  // 16 such messages fit into the memory
  TcpClient source = connect();
  std::vector<TcpClient> stalled;
  for (std::uint32_t i = 0; i < 20; ++i) stalled.push_back(connect_with(Address(kSlow.raw() + i)));
  const std::vector<std::byte> large = numbered(1, 1'000'000);
  for (int round = 0; round < 20; ++round) {
    for (std::uint32_t i = 0; i < stalled.size(); ++i)
      ASSERT_TRUE(
          source.send({.type = -6, .priority = 40, .dest = Address(kSlow.raw() + i)}, large).ok());
  }
  ASSERT_TRUE(is_served(source));
  EXPECT_NE(ask(source, R"({"ask":"stats"})").find("queue_replaced"), std::string::npos);
  TcpClient reader = connect_with(kPing);
  for (std::uint32_t round = 0; round < 5; ++round) {
    // More than its socket accepts at once, so that one message is written partly.
    for (std::uint32_t i = 0; i < 12; ++i)
      ASSERT_TRUE(source.send({.type = -6, .dest = kPing}, large).ok());
    ASSERT_TRUE(is_served(source));
    ASSERT_TRUE(
        source.send({.type = -6, .priority = 200, .dest = kPing}, numbered(2 + round, 100)).ok());
    for (std::uint32_t number = 1; number == 1;) {
      const auto message = reader.receive();
      ASSERT_TRUE(message.ok()) << "in round " << round << ": " << message.error().message();
      number = number_of(message->body);
      ASSERT_TRUE(number == 1 || number == 2 + round) << number;
    }
    // A message of lower priority.
    ASSERT_TRUE(source.send({.type = -6, .dest = kPing}, numbered(100, 100)).ok());
    while (number_of(reader.receive().value().body) != 100) {
    }
  }
}

// The memory of all queues is full of messages for clients that do not read; messages of 12 MB for
// one that does are begun while its socket has room for a part of them only.
TEST_F(TcpTest, AReaderOfLargeMessagesStaysConnectedBesideTwentyThatDoNotRead) {
  start();
  TcpClient source = connect();
  std::vector<TcpClient> stalled;
  for (std::uint32_t i = 0; i < 20; ++i) {
    stalled.push_back(connect_with(Address(kSlow.raw() + i)));
    stalled.back().set_receive_buffer(1 << 20);
  }
  const std::vector<std::byte> part = numbered(1, 100'000);
  for (int round = 0; round < 280; ++round)
    for (std::uint32_t i = 0; i < stalled.size(); ++i)
      ASSERT_TRUE(source.send({.type = -6, .dest = Address(kSlow.raw() + i)}, part).ok());
  ASSERT_TRUE(is_served(source));
  TcpClient reader = connect_with(kPing);
  reader.set_receive_buffer(1 << 20);
  for (std::uint32_t number = 2; number < 8; ++number) {
    ASSERT_TRUE(source.send({.type = -6, .dest = kPing}, numbered(number, 12'000'000)).ok());
    ASSERT_TRUE(is_served(source));
    const auto message = reader.receive();
    ASSERT_TRUE(message.ok()) << number << ": " << message.error().message();
    EXPECT_EQ(number_of(message->body), number);
  }
  // What the others lost is counted.
  EXPECT_NE(ask(source, R"({"ask":"stats"})").find("queue_replaced"), std::string::npos);
}

}  // namespace tcp_slow_reader_test
}  // namespace tims::test
