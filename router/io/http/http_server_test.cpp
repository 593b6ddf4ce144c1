// Bounds of the HTTP side, with a client in the same thread and short times.
#include "router/io/http/http_server.h"

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include "os/clock.h"
#include "router/io/loop.h"
#include "tests/support/patience.h"
#include "tests/support/tcp_socket.h"

namespace tims::io {
namespace http_server_test {

using namespace std::chrono_literals;
using test::kPatience;
using testing::EndsWith;
using testing::StartsWith;

const std::string kUpgrade =
    "GET /tims HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\r\n";
const std::string kGet = "GET /healthz HTTP/1.1\r\n\r\n";

class Client {
 public:
  explicit Client(const std::string& endpoint)
      : socket_(std::move(*test::connect_tcp(endpoint, kPatience))) {}

  void send(std::string_view bytes) {
    EXPECT_EQ(::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  void take() {
    char bytes[65536];
    ssize_t n = 0;
    while ((n = ::recv(socket_.get(), bytes, sizeof bytes, MSG_DONTWAIT)) > 0)
      received.append(bytes, static_cast<std::size_t>(n));
    closed = closed || n == 0 || (n < 0 && errno != EAGAIN);
  }
  void shut_down() { ::shutdown(socket_.get(), SHUT_WR); }
  void send_if_open(std::string_view bytes) {
    (void)::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }

  std::string received;
  bool closed = false;

 private:
  os::File socket_;
};

class HttpServerTest : public testing::Test {
 protected:
  void start(const HttpTimeouts& timeouts = {}) {
    server_.emplace(loop_, log_,
                    HttpPages{.metrics = [this] { return metrics_; },
                              .not_ready = [] { return std::string(); },
                              .ask = [](const std::string&) { return std::string(); },
                              .access = [this]() -> const BrowserAccess& { return access_; },
                              .refused = [](HttpRefusal, const std::string&) {},
                              .console = &console_,
                              .logins = &logins_,
                              .now = [] { return os::now(); }},
                    HttpServer::Actions{.upgrade = [this](StreamSocket, const HttpRequest&,
                                                          const Visitor&) { ++upgrades_; },
                                        .end_turn = [this](Time began) { loop_.end_turn(began); }},
                    timeouts);
    loop_.watch({.next = [this] { return server_->next_timeout(); },
                 .on_timeout = [this](Time now) { server_->on_timeout(now); }});
    const auto where = server_->listen({"127.0.0.1", 0});
    ASSERT_TRUE(where.ok());
    endpoint_ = where->to_string();
  }

  template <typename Condition>
  testing::AssertionResult run_until(Condition condition) {
    const Time limit = os::now() + kPatience;
    while (!condition()) {
      if (os::now() >= limit) return testing::AssertionFailure() << "it did not happen";
      loop_.run_once(os::now() + 10ms);
    }
    return testing::AssertionSuccess();
  }
  testing::AssertionResult run_until_closed(Client& client) {
    return run_until([&] {
      client.take();
      return client.closed;
    });
  }
  testing::AssertionResult run_until_received(Client& client, std::string_view text) {
    return run_until([&] {
      client.take();
      return client.received.ends_with(text);
    });
  }

  std::string metrics_ = "m 1\n";
  const BrowserAccess access_;
  ConsoleFiles console_ = ConsoleFiles::without_console("a test");
  Logins logins_{[](std::span<std::byte>) {}};
  int upgrades_ = 0;
  Loop loop_;
  Log log_{config::LogLevel::kError};
  std::string endpoint_;
  std::optional<HttpServer> server_;
};

TEST_F(HttpServerTest, ManyRequestsOnOneConnection) {
  start();
  Client client(endpoint_);
  for (int i = 0; i < 3; ++i) {
    client.received.clear();
    client.send(kGet);
    ASSERT_TRUE(run_until_received(client, "ok\n"));
  }
  EXPECT_FALSE(client.closed);
  EXPECT_EQ(server_->size(), 1U);
}

TEST_F(HttpServerTest, NoTimerWhileNobodyIsConnected) {
  start();
  EXPECT_EQ(server_->next_timeout(), kNever);
  {
    Client client(endpoint_);
    client.send(kGet);
    ASSERT_TRUE(run_until_received(client, "ok\n"));
    EXPECT_NE(server_->next_timeout(), kNever);
  }
  ASSERT_TRUE(run_until([&] { return server_->size() == 0; }));
  EXPECT_EQ(server_->next_timeout(), kNever);
}

TEST_F(HttpServerTest, ASilentConnectionIsClosed) {
  start({.request = 20ms});
  Client client(endpoint_);
  EXPECT_TRUE(run_until_closed(client));
  EXPECT_EQ(client.received, "");
}

// Sending one byte at a time does not keep a connection open.
TEST_F(HttpServerTest, ASlowRequestIsClosed) {
  start({.request = 100ms});
  Client client(endpoint_);
  const Time began = os::now();
  int sent = 0;
  EXPECT_TRUE(run_until([&] {
    if (++sent < 100) client.send_if_open("G");
    client.take();
    return client.closed;
  }));
  EXPECT_GE(os::now() - began, 100ms);
}

// The time between requests is another one.
TEST_F(HttpServerTest, AnIdleConnectionHasItsOwnTime) {
  start({.request = 60s, .idle = 20ms});
  Client client(endpoint_);
  client.send(kGet);
  EXPECT_TRUE(run_until_closed(client));
  EXPECT_THAT(client.received, EndsWith("ok\n"));
}

TEST_F(HttpServerTest, AClientThatDoesNotReadItsAnswerIsClosed) {
  start({.answer = 50ms, .answer_bytes_per_s = 1e12});
  metrics_.assign(64 << 20, 'x');
  Client client(endpoint_);
  client.send("GET /metrics HTTP/1.1\r\n\r\n");
  ASSERT_TRUE(run_until([&] { return server_->size() == 1; }));
  EXPECT_TRUE(run_until([&] { return server_->size() == 0; }));
  EXPECT_TRUE(run_until_closed(client));
  EXPECT_LT(client.received.size(), metrics_.size());
}

TEST_F(HttpServerTest, ALongerAnswerHasMoreTime) {
  const HttpTimeouts timeouts;
  EXPECT_EQ(timeouts.to_accept(0), 10s);
  EXPECT_EQ(timeouts.to_accept(8'000), 10500ms);
  EXPECT_EQ(timeouts.to_accept(4'000'000), 260s);
  start({.answer = 10ms, .answer_bytes_per_s = 1e6});
  metrics_.assign(64 << 20, 'x');
  Client client(endpoint_);
  const Time began = os::now();
  client.send("GET /metrics HTTP/1.1\r\n\r\n");
  ASSERT_TRUE(run_until([&] { return server_->next_timeout() > began + 60s; }));
}

// The bytes of a file are not copied; HEAD has only its head.
TEST_F(HttpServerTest, AFileOfTheConsole) {
  const std::string page(3 << 20, 'p');
  ASSERT_TRUE(console_.add("large.html", page + "</html>\n").ok());
  start();
  Client head(endpoint_);
  head.send("HEAD /large.html HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_TRUE(run_until_closed(head));
  EXPECT_THAT(head.received, testing::HasSubstr("Content-Length: 3145736\r\n"));
  EXPECT_THAT(head.received, EndsWith("\r\n\r\n"));
  Client client(endpoint_);
  for (int i = 0; i < 2; ++i) {
    client.received.clear();
    client.send("GET /large.html HTTP/1.1\r\nHost: localhost\r\n\r\n");
    ASSERT_TRUE(run_until_received(client, "</html>\n"));
    EXPECT_THAT(client.received, EndsWith("\r\n\r\n" + page + "</html>\n"));
  }
}

TEST_F(HttpServerTest, ALargeAnswerArrivesCompletely) {
  start();
  metrics_.assign(8 << 20, 'x');
  metrics_ += "end\n";
  Client client(endpoint_);
  client.send("GET /metrics HTTP/1.1\r\nConnection: close\r\n\r\n");
  EXPECT_TRUE(run_until_closed(client));
  EXPECT_THAT(client.received, EndsWith("end\n"));
  EXPECT_GT(client.received.size(), metrics_.size());
}

// Unread data of a refused request must not destroy the answer in transit.
TEST_F(HttpServerTest, ARefusalArrivesAlthoughMoreIsSent) {
  start();
  Client client(endpoint_);
  client.send("nonsense\r\n\r\n" + std::string(100'000, 'x'));
  ASSERT_TRUE(run_until_received(client, "\n"));
  client.shut_down();
  EXPECT_TRUE(run_until_closed(client));
  EXPECT_THAT(client.received, StartsWith("HTTP/1.1 400 Bad Request\r\n"));
}

TEST_F(HttpServerTest, AClientThatDoesNotCloseAfterARefusalIsClosed) {
  start({.final_close = 20ms});
  Client client(endpoint_);
  client.send("nonsense\r\n\r\n");
  EXPECT_TRUE(run_until([&] { return server_->size() == 1; }));
  EXPECT_TRUE(run_until([&] { return server_->size() == 0; }));
}

TEST_F(HttpServerTest, AHalfClosedConnectionIsAnswered) {
  start();
  Client client(endpoint_);
  client.send(kGet + kGet);
  client.shut_down();
  EXPECT_TRUE(run_until_closed(client));
  EXPECT_THAT(client.received, EndsWith("ok\n"));
  EXPECT_NE(client.received.find("ok\n"), client.received.rfind("ok\n"));
}

TEST_F(HttpServerTest, TooManyConnectionsTheOneWithTheLeastTimeGoes) {
  start({.request = 30s, .idle = 60s});
  std::vector<std::unique_ptr<Client>> clients;
  for (std::size_t i = 0; i < HttpServer::kConnectionsMax; ++i) {
    clients.push_back(std::make_unique<Client>(endpoint_));
    ASSERT_TRUE(run_until([&] { return server_->size() == i + 1; }));
  }
  clients[0]->send(kGet);  // has time again
  ASSERT_TRUE(run_until_received(*clients[0], "ok\n"));
  Client one_more(endpoint_);
  one_more.send(kGet);
  ASSERT_TRUE(run_until_received(one_more, "ok\n"));
  EXPECT_TRUE(run_until_closed(*clients[1]));
  EXPECT_EQ(server_->size(), HttpServer::kConnectionsMax);
  clients[0]->take();
  EXPECT_FALSE(clients[0]->closed);
}

TEST_F(HttpServerTest, AnEndingRouterAnswersOnceMore) {
  start();
  Client client(endpoint_);
  client.send(kGet);
  ASSERT_TRUE(run_until_received(client, "ok\n"));
  server_->stop_accepting();
  ASSERT_TRUE(run_until([&] { return server_->drained(); }));
  client.send(kGet);
  ASSERT_TRUE(run_until([&] {
    client.take();
    return client.received.find("Connection: close") != std::string::npos;
  }));
  EXPECT_FALSE(test::connect_tcp(endpoint_, kPatience).ok());
}

TEST_F(HttpServerTest, AnUpgradeTakesTheSocketAway) {
  start();
  Client client(endpoint_);
  client.send(kUpgrade);
  EXPECT_TRUE(run_until([&] { return upgrades_ == 1; }));
  EXPECT_EQ(server_->size(), 0U);
  EXPECT_TRUE(run_until_closed(client));  // the test threw it away
  EXPECT_EQ(client.received, "");
}

TEST_F(HttpServerTest, BytesBehindAnUpgradeAreTooEarly) {
  start();
  Client client(endpoint_);
  client.send(kUpgrade + "x");
  EXPECT_TRUE(run_until([&] {
    client.take();
    return client.received.starts_with("HTTP/1.1 400 ");
  }));
  EXPECT_EQ(upgrades_, 0);
}

}  // namespace http_server_test
}  // namespace tims::io
