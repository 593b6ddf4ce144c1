// A router with WebSocket clients, for tests of both.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/eventually.h"
#include "tests/support/router_process.h"
#include "tests/support/tcp_client.h"
#include "tests/system/websocket_client.h"

namespace tims::test {

inline constexpr Address kPage(0x00020000);
inline constexpr Address kLadar(0x00140000);

class WebSocketTest : public testing::Test {
 protected:
  void start(std::vector<std::string> more = {"lifesign.interval=1h"}) {
    more.emplace_back("http.listen=127.0.0.1:0");
    router_.emplace(std::move(more));
    const auto started = router_->start();
    ASSERT_TRUE(started.ok()) << started.error().message();
  }
  WebSocketClient page(std::optional<Address> mailbox = std::nullopt) {
    WebSocketClient client(router_->http());
    EXPECT_TRUE(client.is_open()) << client.answer();
    if (mailbox) {
      EXPECT_TRUE(client.register_mailbox(*mailbox).ok());
    }
    return client;
  }
  TcpClient tcp(Address mailbox) {
    auto client = TcpClient::connect(router_->tcp());
    EXPECT_TRUE(client.ok());
    EXPECT_TRUE(client->register_mailbox(mailbox).ok());
    return std::move(*client);
  }
  // How the router closes a page that sends these bytes in one frame.
  WebSocketClient::Closed close_of(const std::string& bytes) {
    WebSocketClient client = page();
    client.socket().send(bytes);
    return client.wait_for_close();
  }
  std::string metrics() {
    ByteSocket socket(router_->http());
    socket.send("GET /metrics HTTP/1.1\r\nConnection: close\r\n\r\n");
    return socket.take_rest();
  }
  std::uint64_t metric(const std::string& name) {
    const std::string text = metrics();
    const std::size_t at = text.find("\n" + name + " ");
    return at == std::string::npos ? 0 : std::stoull(text.substr(at + name.size() + 2));
  }
  // Waits until a mailbox is free again.
  testing::AssertionResult eventually_free(Address address) {
    auto client = TcpClient::connect(router_->tcp());
    return eventually([&] { return client->register_mailbox(address).ok(); }, "free address");
  }

  std::optional<RouterProcess> router_;
};

}  // namespace tims::test
