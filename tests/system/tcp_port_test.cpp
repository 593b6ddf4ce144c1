// The TCP port with clients that violate the protocol, and with many clients.
#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <random>

#include "tests/support/eventually.h"
#include "tests/system/tcp_fixture.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace tcp_port_test {

using namespace std::chrono_literals;
namespace command = wire::router_command;

constexpr Address kA{0x00140000};
constexpr Address kB{0x00180000};

std::vector<std::byte> header_saying(std::uint32_t length) {
  std::vector<std::byte> bytes(kHeaderSize);
  wire::encode_header({.type = -1, .dest = kA, .src = kB, .length = length},
                      wire::HeaderBytes(bytes.data(), kHeaderSize));
  return bytes;
}

std::size_t open_files(pid_t pid) {
  const std::filesystem::directory_iterator files("/proc/" + std::to_string(pid) + "/fd");
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

// --- Broken messages

TEST_F(TcpTest, AnIncompleteMessageIsNeverForwarded) {
  start();
  TcpClient a = connect_with(kA);
  TcpClient b = connect_with(kB);
  auto half = header_saying(1000);
  half.resize(500);
  ASSERT_TRUE(b.send_bytes(half).ok());
  b.close();
  // When its mailbox has been removed, nothing of it is in transit any more.
  TcpClient c = connect();
  EXPECT_TRUE(eventually([&] { return c.register_mailbox(kB).ok(); }, "the address is free"));
  EXPECT_TRUE(reaches(c, kB, a, kA));
  EXPECT_NE(ask(c, R"({"ask":"stats"})").find("incomplete"), std::string::npos);
}

TEST_F(TcpTest, AResetWithinAMessageDoesNotAffectOthers) {
  start();
  TcpClient a = connect_with(kA);
  TcpClient b = connect_with(kB);
  auto half = header_saying(100'000);
  half.resize(50'000);
  ASSERT_TRUE(b.send_bytes(half).ok());
  b.reset();
  TcpClient c = connect();
  EXPECT_TRUE(eventually([&] { return c.register_mailbox(kB).ok(); }, "the address is free"));
  EXPECT_TRUE(reaches(c, kB, a, kA));
}

TEST_F(TcpTest, MessagesMayArriveInAnyPieces) {
  start();
  TcpClient a = connect_with(kA);
  TcpClient b = connect();
  std::vector<std::byte> bytes = header_saying(16 + 3);
  bytes.resize(19, std::byte{7});
  for (const std::byte byte : bytes) ASSERT_TRUE(b.send_bytes({&byte, 1}).ok());
  const auto message = a.receive();
  ASSERT_TRUE(message.ok());
  EXPECT_EQ(message->body, std::vector<std::byte>(3, std::byte{7}));
}

// --- Lengths

TEST_F(TcpTest, LengthsBelow16AndAboveTheMaximumCloseTheConnection) {
  start({"message.max=64KiB"});
  TcpClient witness = connect_with(kA);
  for (const std::uint32_t length : {0U, 1U, 15U, 65'537U, 0x10000000U, 0xFFFFFFFFU}) {
    TcpClient b = connect_with(kB);
    ASSERT_TRUE(b.send_bytes(header_saying(length)).ok());
    EXPECT_TRUE(b.wait_for_close().ok()) << length;
    EXPECT_FALSE(b.receive(0s).ok()) << "answered: " << length;
  }
  EXPECT_TRUE(is_served(witness));
  EXPECT_NE(ask(witness, R"({"ask":"stats"})").find("bad_length"), std::string::npos);
  EXPECT_NE(ask(witness, R"({"ask":"events","since":0})").find("too_long"), std::string::npos);
}

TEST_F(TcpTest, LengthsOf16AndOfTheMaximumPass) {
  start({"message.max=1MiB"});
  TcpClient a = connect_with(kA);
  TcpClient b = connect();
  for (const std::uint32_t length : {16U, 17U, 1U << 20}) {
    auto bytes = header_saying(length);
    bytes.resize(length, std::byte{9});
    ASSERT_TRUE(b.send_bytes(bytes).ok());
    const auto message = a.receive();
    ASSERT_TRUE(message.ok()) << message.error().message();
    EXPECT_EQ(message->header.length, length);
    EXPECT_EQ(message->body, std::vector<std::byte>(length - 16, std::byte{9}));
  }
}

// Messages sent before the invalid header still arrive.
TEST_F(TcpTest, MessagesBeforeABrokenOneAreForwarded) {
  start();
  TcpClient a = connect_with(kA);
  TcpClient b = connect();
  auto bytes = header_saying(16);
  const auto broken = header_saying(3);
  bytes.insert(bytes.end(), broken.begin(), broken.end());
  ASSERT_TRUE(b.send_bytes(bytes).ok());
  EXPECT_TRUE(b.wait_for_close().ok());
  EXPECT_TRUE(a.receive().ok());
}

TEST_F(TcpTest, GarbageDoesNotAffectOthers) {
  start({"message.max=64KiB"});
  TcpClient a = connect_with(kA);
  TcpClient b = connect_with(kB);
  std::mt19937 random(7);
  for (int round = 0; round < 50; ++round) {
    TcpClient noise = connect();
    std::vector<std::byte> bytes(1 + random() % 5000);
    std::ranges::generate(bytes, [&] { return static_cast<std::byte>(random()); });
    // The router may close the connection during this call.
    [[maybe_unused]] const auto sent = noise.send_bytes(bytes);
  }
  EXPECT_TRUE(reaches(b, kB, a, kA));
}

// --- Many

TEST_F(TcpTest, MoreThan32ClientsExchangeMessages) {
  start();
  std::vector<TcpClient> clients;
  for (std::uint32_t i = 0; i < 200; ++i) clients.push_back(connect_with(Address(i)));
  for (std::uint32_t i = 0; i < 200; ++i) {
    const std::uint32_t other = (i * 7 + 1) % 200;
    EXPECT_TRUE(reaches(clients[i], Address(i), clients[other], Address(other)));
  }
}

TEST_F(TcpTest, TenThousandConnectionsComeAndGo) {
  start();
  TcpClient witness = connect_with(kA);
  const std::size_t before = open_files(router_->process().pid());
  for (int i = 0; i < 10'000; ++i) {
    TcpClient client = connect();
    if (i % 3 == 0) {
      ASSERT_TRUE(client.send_bytes(header_saying(16)).ok());
    }
    if (i % 5 == 0) client.reset();
  }
  EXPECT_TRUE(eventually([&] { return open_files(router_->process().pid()) == before; },
                         "every descriptor is closed"));
  EXPECT_TRUE(is_served(witness));
}

TEST_F(TcpTest, TheLimitOfClientsIsEnforced) {
  start({"limits.clients=3"});
  TcpClient a = connect_with(kA);
  TcpClient b = connect_with(kB);
  TcpClient c = connect_with(Address(3));
  TcpClient d = connect();
  EXPECT_TRUE(d.wait_for_close().ok());
  c.close();
  EXPECT_TRUE(eventually([&] { return connect().register_mailbox(Address(4)).ok(); },
                         "there is room again"));
  EXPECT_TRUE(reaches(a, kA, b, kB));
}

// --- Commands

TEST_F(TcpTest, OnlyTheOwnerDeletesByDefault) {
  start();
  TcpClient a = connect_with(kA);
  TcpClient b = connect();
  EXPECT_FALSE(b.delete_mailbox(kA).ok());
  EXPECT_TRUE(b.delete_mailbox(kB).ok());  // a mailbox without owner
  EXPECT_TRUE(a.delete_mailbox(kA).ok());
  EXPECT_TRUE(b.register_mailbox(kA).ok());
}

TEST_F(TcpTest, CompatDeleteIsForAllClients) {
  start({"tcp.compat_delete=true"});
  TcpClient a = connect_with(kA);
  TcpClient b = connect();
  EXPECT_TRUE(b.delete_mailbox(kA).ok());
  EXPECT_TRUE(b.register_mailbox(kA).ok());
  EXPECT_TRUE(is_served(a));
}

TEST_F(TcpTest, TheWatchdogClosesClientsThatDoNotAnswer) {
  start({lifesign_interval(200ms)});
  TcpClient living = connect_with(kA);
  TcpClient unwatched = connect();
  ASSERT_TRUE(unwatched.send({.type = command::kDisableWatchdog}).ok());
  unwatched.set_answers_lifesigns(false);
  TcpClient silent = connect_with(kB);
  silent.set_answers_lifesigns(false);
  // Both clients must be called in turns, because a client answers only during a call.
  EXPECT_TRUE(eventually([&] { return is_served(living) && silent.wait_for_close(10ms).ok(); },
                         "silent is closed"));
  EXPECT_GE(living.lifesigns(), 1U);
  EXPECT_EQ(unwatched.lifesigns(), 0U);
  EXPECT_TRUE(is_served(unwatched));
  EXPECT_TRUE(living.register_mailbox(kB).ok());
  EXPECT_NE(ask(living, R"({"ask":"events","since":0})").find("watchdog_closed"),
            std::string::npos);
}

}  // namespace tcp_port_test
}  // namespace tims::test
