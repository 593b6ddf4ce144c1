// How WebSocket clients of a real router disconnect, and clients that do not read.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/system/websocket_fixture.h"
#include "wire/tcp_protocol.h"

namespace tims::test {
namespace websocket_end_test {

using namespace std::chrono_literals;
using Closed = WebSocketClient::Closed;

// --- Connecting and disconnecting

TEST_F(WebSocketTest, APageThatClosesIsAnsweredAndRemoved) {
  start();
  WebSocketClient browser = page(kPage);
  browser.send({WebSocketClient::kClose, true, std::string("\x03\xe9") + "bye"});
  EXPECT_EQ(browser.wait_for_close().code, 1001);
  EXPECT_TRUE(eventually_free(kPage));
}

TEST_F(WebSocketTest, APageThatDisconnectsIsRemoved) {
  start();
  {
    WebSocketClient browser = page(kPage);
    browser.socket().send(WebSocketClient::to_bytes({WebSocketClient::kBinary, false, "half a"}));
  }
  EXPECT_TRUE(eventually_free(kPage));
  EXPECT_EQ(metric("tims_router_drops_total{reason=\"incomplete\"}"), 1U);
}

TEST_F(WebSocketTest, ManyPagesComeAndGo) {
  start();
  TcpClient robot = tcp(kLadar);
  for (int i = 0; i < 200; ++i) {
    WebSocketClient browser = page(Address(1000 + static_cast<std::uint32_t>(i)));
    ASSERT_TRUE(browser.send_message({.dest = kLadar, .src = Address(1)}, std::to_string(i)));
    ASSERT_EQ(text_of(robot.receive()->body), std::to_string(i));
  }
  EXPECT_TRUE(eventually([&] { return metric("tims_router_clients{port=\"websocket\"}") == 0; },
                         "no page left"));
}

TEST_F(WebSocketTest, AnExitingRouterClosesWithItsReason) {
  start();
  WebSocketClient browser = page(kPage);
  router_->process().signal(SIGTERM);
  EXPECT_EQ(browser.wait_for_close(), (Closed{1001, "the router is shutting down"}));
  const auto status = router_->process().wait();
  ASSERT_TRUE(status.ok());
  EXPECT_TRUE(status->success());
}

// --- Keep-alive

TEST_F(WebSocketTest, AClientThatAnswersPingsStays) {
  start({lifesign_interval(300ms)});
  WebSocketClient browser = page(kPage);
  for (int i = 0; i < 4; ++i) {
    const auto ping = browser.take_frame();
    ASSERT_TRUE(ping);
    ASSERT_EQ(ping->opcode, WebSocketClient::kPing);
    browser.send({WebSocketClient::kPong, true, ping->payload});
  }
  TcpClient robot = tcp(kLadar);
  ASSERT_TRUE(robot.send({.dest = kPage, .src = kLadar}, bytes_of("still there")).ok());
  const auto message = browser.receive();
  ASSERT_TRUE(message.ok()) << message.error().message();
  EXPECT_EQ(text_of(message->body), "still there");
}

TEST_F(WebSocketTest, AClientThatDoesNotAnswerPingsIsClosed) {
  start({lifesign_interval(100ms)});
  WebSocketClient browser = page(kPage);
  EXPECT_EQ(browser.wait_for_close(), Closed{});
  EXPECT_TRUE(eventually_free(kPage));
  EXPECT_EQ(metric("tims_router_events_total{event=\"watchdog_closed\"}"), 1U);
}

TEST_F(WebSocketTest, TheOriginalsLifesignIsSentOnRequest) {
  start({lifesign_interval(100ms)});
  WebSocketClient browser = page();
  browser.send_message({.type = wire::router_command::kEnableWatchdog});
  const auto lifesign = browser.receive();
  ASSERT_TRUE(lifesign.ok());
  EXPECT_TRUE(is_lifesign(lifesign->header));
  // The client answers pings, but not lifesigns.
  auto end = browser.receive();
  while (end.ok()) end = browser.receive();
  EXPECT_EQ(end.error().detail(), "opcode 8");
}

// --- Slow readers

class SlowPageTest : public WebSocketTest {
 protected:
  static constexpr std::size_t kBodySize = 10'000;

  void SetUp() override { begin("lifesign.interval=1h"); }

  void begin(const std::string& lifesign) {
    robot_.reset();
    start({lifesign, "message.max=64KiB", "http.queue=256KiB"});
    browser_.emplace(router_->http());
    browser_->socket().set_receive_buffer(32 << 10);
    ASSERT_TRUE(browser_->register_mailbox(kPage).ok());
    robot_.emplace(tcp(kLadar));
  }
  // The number, repeated.
  static std::string body(int number) {
    std::string text;
    while (text.size() < kBodySize) text += std::to_string(number) + ' ';
    text.resize(kBodySize);
    return text;
  }
  void send(int number, std::uint8_t priority) {
    const Header header{.priority = priority, .dest = kPage, .src = kLadar};
    ASSERT_TRUE(robot_->send(header, bytes_of(body(number))).ok());
  }
  std::uint64_t drops(const std::string& reason) {
    return metric("tims_router_drops_total{reason=\"" + reason + "\"}");
  }
  // Sends until the router has dropped some for this reason; returns the number sent.
  int send_until_lost(const std::string& reason, int first, std::uint8_t priority) {
    int number = first;
    while (drops(reason) == 0 && number - first < 5000) {
      for (int i = 0; i < 20; ++i) send(number++, priority);
      (void)robot_->receive(0ms);  // answers a lifesign
    }
    EXPECT_GT(drops(reason), 0U);
    return number - first;
  }

  std::optional<WebSocketClient> browser_;
  std::optional<TcpClient> robot_;
};

TEST_F(SlowPageTest, OldMessagesAreDroppedOthersArriveCompleteUrgentOnesOvertake) {
  const int sent = send_until_lost("queue_replaced", 0, 1);
  send(-1, 200);
  const auto lost_before = drops("queue_replaced");
  EXPECT_LE(metric("tims_router_queued_bytes{port=\"websocket\"}"), 256U << 10);
  std::vector<int> numbers;
  int urgent_at = -1;
  const int arriving = sent - static_cast<int>(lost_before);
  for (int i = 0; i < arriving + 1; ++i) {
    const auto message = browser_->receive();
    ASSERT_TRUE(message.ok()) << message.error().message();
    const int number = std::stoi(text_of(message->body));
    ASSERT_EQ(text_of(message->body), body(number));
    if (number < 0)
      urgent_at = i;
    else
      numbers.push_back(number);
  }
  // They arrive in order, including the newest; the missing ones are older ones from the queue.
  EXPECT_TRUE(std::ranges::is_sorted(numbers));
  EXPECT_EQ(numbers.back(), sent - 1);
  EXPECT_EQ(static_cast<int>(numbers.size()), arriving);
  // It overtook the messages in the queue: twenty, less those that the socket has accepted since.
  EXPECT_GT(urgent_at, 0);
  EXPECT_LT(urgent_at, arriving - 3);
}

TEST_F(SlowPageTest, UnreadMessagesAreCountedWhenItDisconnects) {
  const int sent = send_until_lost("queue_replaced", 0, 1);
  const std::uint64_t replaced = drops("queue_replaced");
  browser_.reset();
  EXPECT_TRUE(eventually([&] { return drops("client_gone") > 0; }, "messages of a client gone"));
  EXPECT_LE(drops("client_gone") + replaced, static_cast<std::uint64_t>(sent));
  EXPECT_EQ(metric("tims_router_queued_bytes{port=\"websocket\"}"), 0U);
}

// Pings reach it late and are not answered here, but it reads.
TEST_F(SlowPageTest, AClientThatReadsStays) {
  begin(lifesign_interval(1s));
  const int sent = send_until_lost("queue_replaced", 0, 1);
  for (int beat = 0; beat < 3; ++beat) {
    const auto lifesigns = robot_->lifesigns();
    for (int i = 0; i < 10; ++i) send(sent + i, 1);
    EXPECT_EQ(browser_->socket().take(64 << 10).size(), 64U << 10);
    while (robot_->lifesigns() == lifesigns) (void)robot_->receive(20ms);
  }
  EXPECT_EQ(metric("tims_router_clients{port=\"websocket\"}"), 1U);
}

TEST_F(SlowPageTest, AClientThatDoesNotReadIsClosed) {
  begin(lifesign_interval(100ms));
  send_until_lost("queue_replaced", 0, 1);
  EXPECT_TRUE(eventually([&] { return drops("client_gone") > 0; }, "messages of a client gone"));
  EXPECT_GE(metric("tims_router_events_total{event=\"watchdog_closed\"}"), 1U);
}

// The frame being written never completes; the router does not wait for it.
TEST_F(SlowPageTest, AnExitingRouterDoesNotWaitForIt) {
  send_until_lost("queue_replaced", 0, 1);
  const auto status = router_->stop();
  ASSERT_TRUE(status.ok());
  EXPECT_TRUE(status->success());
}

}  // namespace websocket_end_test
}  // namespace tims::test
