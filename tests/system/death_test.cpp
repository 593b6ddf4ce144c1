// Programs are killed at any time by SIGKILL, and no other program is affected.
#include <csignal>
#include <cstring>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "tests/support/child_process.h"
#include "tests/support/eventually.h"
#include "tests/support/router_process.h"
#include "tests/support/tcp_client.h"
#include "tims/session.h"

namespace tims::test {
namespace death_test {

class DeathTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto started = router_.start();
    ASSERT_TRUE(started.ok()) << started.error().message();
    auto session = Session::connect({.router = router_.socket_path(),
                                     .timeout = kPatience,
                                     .on_event = [](const SessionEvent&) {}});
    ASSERT_TRUE(session.ok());
    session_.emplace(std::move(*session));
  }
  ChildProcess actor(const std::string& role, const std::string& address) {
    auto child = ChildProcess::start({TIMS_ACTOR_PROGRAM, role, router_.socket_path(), address});
    EXPECT_TRUE(child.ok());
    return std::move(*child);
  }
  Mailbox open(std::uint32_t address, std::uint32_t slots = 8) {
    auto mailbox = session_->open({.address = Address(address), .slots = slots, .body_max = 64});
    EXPECT_TRUE(mailbox.ok()) << mailbox.error().message();
    return std::move(*mailbox);
  }
  static void expect_line(ChildProcess& child, const char* line) {
    const auto found = child.wait_for_line(line);
    ASSERT_TRUE(found.ok()) << found.error().message();
  }

  RouterProcess router_;
  std::optional<Session> session_;
};

TEST_F(DeathTest, SlotsOfAKilledProducerAreReleased) {
  Mailbox sender = open(1);
  Mailbox owner = open(2, 3);
  ChildProcess child = actor("hold-loans", "3");
  expect_line(child, "holding");
  EXPECT_EQ(sender.send({.dest = Address(2), .priority = 255}).error().code(), Errc::kFull);
  (void)child.stop(SIGKILL);
  for (int i = 0; i < 3; ++i)
    EXPECT_TRUE(eventually([&] { return sender.send({.dest = Address(2)}).ok(); }, "a free slot"));
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(owner.peek_for(kPatience).ok());
  EXPECT_EQ(owner.counters().reclaimed, 3U);
}

TEST_F(DeathTest, SendersGetAnErrorWhenTheOwnerIsKilledWhilePeeking) {
  Mailbox sender = open(1);
  ChildProcess child = actor("hold-peek", "2");
  expect_line(child, "ready");
  ASSERT_TRUE(sender.send({.dest = Address(2), .type = 21}).ok());
  expect_line(child, "peeking");
  (void)child.stop(SIGKILL);
  EXPECT_TRUE(eventually(
      [&] {
        (void)sender.send({.dest = Address(2), .type = 21});
        const auto answer = sender.try_peek();
        return answer && answer->header().type == type::kNotAvailable;
      },
      "NOT_AVAILABLE"));
  ChildProcess successor = actor("hold-peek", "2");
  expect_line(successor, "ready");
  ASSERT_TRUE(sender.send({.dest = Address(2), .type = 21}).ok());
  expect_line(successor, "peeking");
}

TEST_F(DeathTest, ProducersKilledInAFloodLeaveAWorkingMailbox) {
  Mailbox sender = open(1);
  Mailbox owner = open(2);
  for (int round = 0; round < 20; ++round) {
    ChildProcess child = actor("flood", "3");
    for (int i = 0; i < 200; ++i) ASSERT_TRUE(owner.peek_for(kPatience).ok());
    (void)child.stop(SIGKILL);
    owner.clean();
  }
  // The router reclaims the slot that the last one was writing; then every slot can be used.
  EXPECT_TRUE(eventually(
      [&] {
        owner.clean();
        for (int i = 0; i < 8; ++i)
          if (!sender.send({.dest = Address(2)}).ok()) return false;
        std::size_t received = 0;
        while (owner.try_peek().ok()) ++received;
        return received == 8;
      },
      "eight slots"));
}

TEST_F(DeathTest, LocalTrafficContinuesWhenTheRouterIsKilledUnderLoad) {
  Mailbox client = open(1);
  ChildProcess server = actor("echo", "2");
  expect_line(server, "ready");
  const auto round_trip = [&] {
    if (!client.send({.dest = Address(2), .type = 21}).ok()) return false;
    const auto reply = client.peek_for(kPatience);
    return reply && reply->header().type == type::kOk;
  };
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(round_trip());
  for (int round = 0; round < 3; ++round) {
    router_.kill();
    for (int i = 0; i < 1000; ++i) ASSERT_TRUE(round_trip()) << i;
    ASSERT_TRUE(router_.start().ok());
    EXPECT_TRUE(eventually([&] { return session_->connected(); }, "connected again"));
    for (int i = 0; i < 1000; ++i) ASSERT_TRUE(round_trip()) << i;
  }
  // A new client finds the server, which has registered again by itself.
  Mailbox late = open(9);
  EXPECT_TRUE(eventually(
      [&] {
        if (!late.send({.dest = Address(2), .type = 21}).ok()) return false;
        const auto reply = late.peek_for(kPatience);
        return reply && reply->header().type == type::kOk;
      },
      "an answer to the new client"));
}

TEST_F(DeathTest, AnOwnerKilledWithTheRouterIsGoneForTheNextRouter) {
  Mailbox client = open(1);
  ChildProcess server = actor("echo", "2");
  expect_line(server, "ready");
  ASSERT_TRUE(client.send({.dest = Address(2), .type = 21}).ok());
  ASSERT_TRUE(client.peek_for(kPatience).ok());
  router_.kill();
  (void)server.stop(SIGKILL);
  ASSERT_TRUE(router_.start().ok());
  // Nothing could mark its mailbox as closed. After the time for reconnecting the router reports
  // it.
  EXPECT_TRUE(eventually(
      [&] {
        (void)client.send({.dest = Address(2), .type = 21});
        const auto answer = client.try_peek();
        return answer && answer->header().type == type::kNotAvailable;
      },
      "NOT_AVAILABLE"));
}

// Messages that a program has sent are delivered, even if it closes or crashes directly afterwards.
class LastMessagesTest : public DeathTest, public testing::WithParamInterface<const char*> {};

TEST_P(LastMessagesTest, AreDelivered) {
  constexpr std::uint32_t kCount = 900;
  auto receiver = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(receiver.ok());
  ASSERT_TRUE(receiver->register_mailbox(Address(2)).ok());
  Mailbox starter = open(1);
  ChildProcess program = actor(GetParam(), "3");
  expect_line(program, "ready");
  EXPECT_TRUE(receiver->receive().ok());
  {  // A loan, because its mailbox is looked up before the router is stopped.
    auto go = starter.loan({.dest = Address(3), .type = -7}, 0);
    ASSERT_TRUE(go.ok());
    router_.process().signal(SIGSTOP);
    ASSERT_TRUE(go->send().ok());
  }
  expect_line(program, "sent");
  if (std::string(GetParam()) == "send-and-die") {
    EXPECT_EQ(program.wait()->signal, SIGKILL);
  }
  router_.process().signal(SIGCONT);
  for (std::uint32_t number = 1; number < kCount; ++number) {
    const auto got = receiver->receive(kPatience / 10);
    ASSERT_TRUE(got.ok()) << "after " << number << " of " << kCount;
    std::uint32_t body = 0;
    ASSERT_EQ(got->body.size(), sizeof body);
    std::memcpy(&body, got->body.data(), sizeof body);
    ASSERT_EQ(body, number);
  }
}

INSTANTIATE_TEST_SUITE_P(Programs, LastMessagesTest,
                         testing::Values("send-and-close", "send-and-die"));

}  // namespace death_test
}  // namespace tims::test
