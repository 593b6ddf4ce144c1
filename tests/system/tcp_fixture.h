// A router and clients of the original protocol.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/router_process.h"
#include "tests/support/tcp_client.h"

namespace tims::test {

class TcpTest : public testing::Test {
 protected:
  // `settings`: "key=value".
  void start(std::vector<std::string> settings = {}) {
    router_.emplace(std::move(settings));
    const auto started = router_->start();
    ASSERT_TRUE(started.ok()) << started.error().message();
  }

  TcpClient connect() {
    auto client = TcpClient::connect(router_->tcp());
    EXPECT_TRUE(client.ok()) << client.error().message();
    return std::move(*client);
  }
  TcpClient connect_with(Address mailbox) {
    TcpClient client = connect();
    const auto registered = client.register_mailbox(mailbox);
    EXPECT_TRUE(registered.ok()) << registered.error().message();
    return client;
  }

  // The router's answer to a request of the admin protocol.
  static std::string ask(TcpClient& client, std::string_view question) {
    EXPECT_TRUE(client.send({.type = type::kAdminRequest}, bytes_of(question)).ok());
    for (;;) {
      const auto answer = client.receive();
      if (!answer) return answer.error().message();
      if (answer->header.type != type::kAdminReply) continue;
      return {reinterpret_cast<const char*>(answer->body.data()), answer->body.size()};
    }
  }
  // Whether the router has processed everything this client sent before, and still serves it.
  static testing::AssertionResult is_served(TcpClient& client) {
    const std::string answer = ask(client, R"({"ask":"ping"})");
    if (answer.find("tims/ping") != std::string::npos) return testing::AssertionSuccess();
    return testing::AssertionFailure() << answer;
  }
  // Sends a message from `from` and waits for it at `to`.
  static testing::AssertionResult reaches(TcpClient& from, Address source, TcpClient& to,
                                          Address dest) {
    static std::uint8_t number = 0;
    const Header header{.type = 21, .seq_nr = ++number, .dest = dest, .src = source};
    if (auto sent = from.send(header); !sent) {
      return testing::AssertionFailure() << sent.error().message();
    }
    const auto received = to.receive();
    if (!received) return testing::AssertionFailure() << received.error().message();
    if (received->header.seq_nr == number) return testing::AssertionSuccess();
    return testing::AssertionFailure() << "another message arrived";
  }

  std::optional<RouterProcess> router_;
};

}  // namespace tims::test
