// A router for each test, and helper functions of the tests with native components.
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "tests/support/message.h"
#include "tests/support/router_process.h"
#include "tests/support/tcp_client.h"
#include "tims/session.h"

namespace tims::test {

using namespace std::chrono_literals;

class LocalTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto started = router_.start();
    ASSERT_TRUE(started.ok()) << started.error().message();
  }

  Session session(const std::string& name = "test") {
    auto connected = Session::connect({.name = name,
                                       .router = router_.socket_path(),
                                       .timeout = kPatience,
                                       .on_event = [](const SessionEvent&) {}});
    EXPECT_TRUE(connected.ok()) << connected.error().message();
    return std::move(*connected);
  }
  static Mailbox open(Session& session, std::uint32_t address, MailboxOptions options = {}) {
    options.address = Address(address);
    auto opened = session.open(options);
    EXPECT_TRUE(opened.ok()) << opened.error().message();
    return std::move(*opened);
  }
  static std::string receive(Mailbox& mailbox, Duration timeout = kPatience) {
    auto message = mailbox.peek_for(timeout);
    return message ? text_of(message->body()) : std::string(name(message.error().code()));
  }
  static Result<void> send(Mailbox& from, std::uint32_t to, const std::string& text,
                           std::uint8_t priority = 0) {
    return from.send({.dest = Address(to), .type = 21, .priority = priority}, bytes_of(text));
  }

  RouterProcess router_;
};

}  // namespace tims::test
