// Hostile or broken clients at the TCP port: other clients are not affected.
#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/support/eventually.h"
#include "tests/system/tcp_fixture.h"
#include "tims/session.h"
#include "wire/header.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace tcp_hostile_test {

using namespace std::chrono_literals;

constexpr Address kPilot(0x02180000);
constexpr Address kLadar(0x02140000);

class HostileGuestTest : public TcpTest {
 protected:
  // "VmHWM" of the router: its peak memory.
  std::size_t peak_bytes() {
    std::ifstream status("/proc/" + std::to_string(router_->process().pid()) + "/status");
    for (std::string line; std::getline(status, line);) {
      if (line.starts_with("VmHWM:")) return std::stoul(line.substr(6)) * 1024;
    }
    return 0;
  }
  void expect_grown_by_less(std::size_t bytes, std::size_t before) {
    if (kSlowdown > 1) return;  // sanitizers keep freed memory
    EXPECT_LT(peak_bytes() - before, bytes);
  }
  std::size_t descriptors() {
    const std::filesystem::path folder =
        "/proc/" + std::to_string(router_->process().pid()) + "/fd";
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
  }

  static void append_message(std::vector<std::byte>& bytes, Header header, std::string_view body) {
    header.length = static_cast<std::uint32_t>(kHeaderSize + body.size());
    bytes.resize(bytes.size() + kHeaderSize);
    wire::encode_header(header, std::span(bytes).last<kHeaderSize>());
    const auto text = bytes_of(body);
    bytes.insert(bytes.end(), text.begin(), text.end());
  }
};

// Regression: the router once produced 572 MB of answers in one turn of its loop, which took 14 s.
TEST_F(HostileGuestTest, ThousandsOfQuestionsAtOnceAreAnsweredInTurns) {
  constexpr int kQuestions = 8'000;
  start({"lifesign.interval=1h"});
  TcpClient guest = connect();
  for (std::uint32_t i = 0; i < 1'000; ++i) {
    ASSERT_TRUE(guest.register_mailbox(Address(0x02100000 + i)).ok());
  }
  TcpClient bystander = connect_with(kPilot);
  const std::size_t before = peak_bytes();

  std::vector<std::byte> questions;
  for (int i = 0; i < kQuestions; ++i)
    append_message(questions, {.type = type::kAdminRequest}, R"({"ask":"routes"})");
  ASSERT_TRUE(guest.send_bytes(questions).ok());
  EXPECT_TRUE(reaches(bystander, kPilot, bystander, kPilot));

  int answers = 0;
  int busy = 0;
  while (answers + busy < kQuestions) {
    const auto answer = guest.receive();
    ASSERT_TRUE(answer.ok()) << answers << " " << busy << " " << answer.error().message();
    const std::string_view text(reinterpret_cast<const char*>(answer->body.data()),
                                answer->body.size());
    ++(text.find(R"("busy")") != std::string_view::npos ? busy : answers);
  }
  EXPECT_GE(answers, 64);
  expect_grown_by_less(std::size_t{64} << 20, before);
}

// Regression: after a message that is collected and flushed separately, a connection was not
// closed.
TEST_F(HostileGuestTest, ABadHeaderAfterALargeMessageClosesTheConnection) {
  constexpr int kGuests = 20;
  start({"lifesign.interval=1h"});
  TcpClient bystander = connect_with(kPilot);
  ASSERT_TRUE(is_served(bystander));
  const std::size_t before = descriptors();
  std::vector<std::byte> bytes;
  append_message(bytes, {.type = 21, .dest = kLadar, .src = Address(3)}, std::string(5'000, 'x'));
  const std::size_t first =
      3'000;  // so that the rest of the message arrives together with the bad header
  bytes.resize(bytes.size() + kHeaderSize);  // a length of 0 bytes
  std::vector<TcpClient> guests;
  for (int i = 0; i < kGuests; ++i) {
    guests.push_back(connect());
    ASSERT_TRUE(guests.back().send_bytes(std::span(bytes).first(first)).ok());
    ASSERT_TRUE(is_served(bystander));
    ASSERT_TRUE(guests.back().send_bytes(std::span(bytes).subspan(first)).ok());
    EXPECT_TRUE(guests.back().wait_for_close().ok());
  }
  EXPECT_TRUE(eventually([&] { return descriptors() == before; }, "every descriptor is closed"));
  EXPECT_NE(ask(bystander, R"({"ask":"stats"})").find(R"("protocol_error":20)"), std::string::npos);
}

// Many clients each send 15 of 16 MiB, and then nothing.
TEST_F(HostileGuestTest, HalfMessagesDoNotUseUpTheMemory) {
  constexpr std::uint32_t kMessage = 16 << 20;
  constexpr std::size_t kSent = 15 << 20;
  constexpr int kGuests = 20;
  start({"lifesign.interval=1h"});
  TcpClient bystander = connect_with(kPilot);
  const std::size_t before = peak_bytes();
  std::vector<std::byte> half(kSent);
  wire::encode_header({.type = 21, .dest = kPilot, .length = kMessage},
                      std::span(half).first<kHeaderSize>());
  std::vector<TcpClient> guests;
  for (int i = 0; i < kGuests; ++i) {
    guests.push_back(connect());
    // The first clients are closed while others still send.
    ASSERT_TRUE(guests.back().send_bytes(half).ok());
  }
  EXPECT_TRUE(guests.front().wait_for_close().ok());
  expect_grown_by_less(std::size_t{100} << 20, before);
  EXPECT_TRUE(eventually(
      [&] {
        return ask(bystander, R"({"ask":"stats"})").find(R"("incomplete")") != std::string::npos;
      },
      "what did not come to its end is counted"));
  // A client that sends a complete message succeeds.
  const std::vector<std::byte> body(kMessage - kHeaderSize);
  TcpClient sender = connect();
  ASSERT_TRUE(sender.send({.type = 21, .dest = kPilot}, body).ok());
  const auto whole = bystander.receive();
  ASSERT_TRUE(whole.ok()) << whole.error().message();
  EXPECT_EQ(whole->body.size(), body.size());
}

TEST_F(HostileGuestTest, SilentClientsDoNotExcludeOthers) {
  start({"limits.clients=8", "lifesign.interval=1h"});
  TcpClient quiet = connect_with(kLadar);
  std::vector<TcpClient> silent;
  for (int i = 0; i < 20; ++i) silent.push_back(connect());
  // Components of this host have a separate limit.
  auto session = Session::connect({.router = router_->socket_path(), .timeout = kPatience});
  ASSERT_TRUE(session.ok()) << session.error().message();
  auto mailbox = session->open({.address = Address(0x7F000001)});
  EXPECT_TRUE(mailbox.ok());
  // The oldest connection that sent nothing is closed to make room for a client that sends.
  TcpClient newcomer = connect_with(kPilot);
  EXPECT_TRUE(silent.front().wait_for_close().ok());
  // A registered client may be silent for any time.
  EXPECT_TRUE(reaches(newcomer, kPilot, quiet, kLadar));
}

// Regression: 4000 refusals with different texts once produced 5 MB of log in 4 s.
TEST_F(HostileGuestTest, RefusalsDoNotFillTheLog) {
  start({"lifesign.interval=1h", "limits.mailboxes_per_client=1"});
  TcpClient guest = connect_with(kLadar);
  for (std::uint32_t i = 0; i < 4'000; ++i) {
    const std::uint32_t address = 0x02200000 + i;
    std::array<std::byte, 4> body{};
    std::memcpy(body.data(), &address, sizeof address);
    ASSERT_TRUE(guest.send({.type = wire::router_command::kMailboxInit}, body).ok());
  }
  ASSERT_TRUE(is_served(guest));
  const std::string log = router_->process().standard_error();
  EXPECT_NE(log.find("limits.mailboxes_per_client"), std::string::npos);
  EXPECT_LT(std::count(log.begin(), log.end(), '\n'), 40);
}

TEST_F(HostileGuestTest, GuestsChangeTheRouterOnlyWhenAllowed) {
  const std::string_view change = R"({"ask":"route_add","match":"*","via":"base"})";
  start();
  TcpClient guest = connect();
  EXPECT_NE(ask(guest, change).find("denied"), std::string::npos);
  start({"tcp.admin=true"});
  guest = connect();
  EXPECT_NE(ask(guest, change).find("no_such_link"), std::string::npos) << "allowed, but wrong";
}

}  // namespace tcp_hostile_test
}  // namespace tims::test
