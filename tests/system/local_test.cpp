// Components of one host with a real router: the guarantees of libtims.
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include "tests/support/eventually.h"
#include "tests/system/local_fixture.h"

namespace tims::test {
namespace local_test {

TEST_F(LocalTest, AMailboxThatSpinsSleepsAfterTheSpinTime) {
  Session s = session();
  Mailbox a = open(s, 1, {.spin = 1ms});
  EXPECT_EQ(receive(a, 20ms), "timeout");
  EXPECT_EQ(receive(a, 100us), "timeout") << "the deadline is before the end of spinning";
  std::thread sender([&] { EXPECT_TRUE(send(a, 1, "late")); });
  EXPECT_EQ(receive(a), "late");
  sender.join();
}

TEST_F(LocalTest, BodiesAtTheLimitOfTheMailbox) {
  Session s = session();
  Mailbox a = open(s, 1, {.body_max = 100});
  EXPECT_TRUE(send(a, 1, std::string(99, 'x')).ok());
  EXPECT_TRUE(send(a, 1, std::string(100, 'x')).ok());
  EXPECT_EQ(send(a, 1, std::string(101, 'x')).error().code(), Errc::kTooBig);
  EXPECT_EQ(a.counters().too_big, 1U);
}

TEST_F(LocalTest, LoansAreBuiltInPlaceAndDroppedLoansHaveNoEffect) {
  Session s = session();
  Mailbox a = open(s, 1);
  Mailbox b = open(s, 2, {.slots = 1});
  for (int i = 0; i < 10; ++i) {
    auto dropped = a.loan({.dest = Address(2)}, 4);
    ASSERT_TRUE(dropped.ok()) << dropped.error().message();
  }
  auto loan = a.loan({.dest = Address(2), .type = 5}, 4);
  ASSERT_TRUE(loan.ok());
  EXPECT_EQ(a.loan({.dest = Address(2)}, 4).error().code(), Errc::kFull);
  std::memcpy(loan->body().data(), "abcd", 4);
  EXPECT_EQ(b.try_peek().error().code(), Errc::kEmpty);
  ASSERT_TRUE(loan->send().ok());
  EXPECT_EQ(receive(b), "abcd");
}

TEST_F(LocalTest, TwoOwnersForAnAddressAreRefusedAndNamed) {
  Session first = session("laser");
  Session second = session("impostor");
  Mailbox owner = open(first, 0x00140000);
  const auto refused = second.open({.address = Address(0x00140000)});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code(), Errc::kAddressInUse);
  const std::string text = refused.error().message();
  EXPECT_NE(text.find("Ladar(0/0)"), std::string::npos) << text;
  EXPECT_NE(text.find("laser"), std::string::npos) << text;
  EXPECT_NE(text.find(std::to_string(::getpid())), std::string::npos) << text;
}

TEST_F(LocalTest, AnEventLoopCanWaitForAMailbox) {
  Session s = session();
  Mailbox a = open(s, 1);
  Mailbox b = open(s, 2, {.event_fd = true});
  ASSERT_GE(b.event_fd(), 0);
  EXPECT_EQ(a.event_fd(), -1);
  const auto readable = [&](int ms) {
    pollfd p{b.event_fd(), POLLIN, 0};
    return ::poll(&p, 1, ms) == 1;
  };
  EXPECT_EQ(b.try_peek().error().code(), Errc::kEmpty);  // arms the descriptor
  EXPECT_FALSE(readable(0));
  for (int round = 0; round < 100; ++round) {
    ASSERT_TRUE(send(a, 2, "x").ok());
    ASSERT_TRUE(send(a, 2, "y").ok());
    ASSERT_TRUE(readable(kPatienceMs)) << round;
    EXPECT_EQ(receive(b, 0ns), "x");
    EXPECT_EQ(receive(b, 0ns), "y");
    EXPECT_EQ(b.try_peek().error().code(), Errc::kEmpty);
    ASSERT_FALSE(readable(0)) << round;
  }
  std::thread sender([&] { EXPECT_TRUE(send(a, 2, "blocking works too").ok()); });
  EXPECT_EQ(receive(b), "blocking works too");
  sender.join();
}

// --- together with TCP clients ---

TEST_F(LocalTest, OriginalProgramsAndNativeOnesExchangeMessages) {
  Session s = session();
  Mailbox native = open(s, 0x00140000);
  auto old = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(old.ok()) << old.error().message();
  ASSERT_TRUE(old->register_mailbox(Address(0x00020101)).ok());

  ASSERT_TRUE(
      old->send({.type = 4, .seq_nr = 9, .dest = native.address(), .src = Address(0x00020101)},
                bytes_of("ask"))
          .ok());
  const auto request = native.peek_for(kPatience);
  ASSERT_TRUE(request.ok());
  EXPECT_EQ(text_of(request->body()), "ask");
  ASSERT_TRUE(native.reply(request->header(), type::kData, bytes_of("answer")).ok());
  const auto reply = old->receive();
  ASSERT_TRUE(reply.ok()) << reply.error().message();
  EXPECT_EQ(reply->header.type, type::kData);
  EXPECT_EQ(reply->header.seq_nr, 9);
  EXPECT_EQ(text_of(reply->body), "answer");
}

TEST_F(LocalTest, FlagsOfNativeStreamsAreNotForwardedToOriginalPrograms) {
  Session s = session();
  Mailbox native = open(s, 0x00140000);
  auto old = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(old.ok());
  ASSERT_TRUE(old->register_mailbox(Address(1)).ok());
  ASSERT_TRUE(native.send({.dest = Address(1), .type = -6, .stream = true}).ok());
  const auto got = old->receive();
  ASSERT_TRUE(got.ok());
  EXPECT_EQ(got->header.flags, flag::kNativeOrder);
}

TEST_F(LocalTest, LargeMessagesPassTheRouterInBothDirections) {
  Session s = session();
  Mailbox native = open(s, 1, {.slots = 4, .body_max = (16U << 20) - 16});
  auto old = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(old.ok());
  ASSERT_TRUE(old->register_mailbox(Address(2)).ok());
  std::vector<std::byte> body((16U << 20) - 16);
  for (std::size_t i = 0; i < body.size(); ++i) body[i] = static_cast<std::byte>(i * 7 + i / 4096);
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(native.send({.dest = Address(2), .type = -6}, body).ok());
    const auto got = old->receive();
    ASSERT_TRUE(got.ok()) << got.error().message();
    EXPECT_TRUE(std::ranges::equal(got->body, body));
    ASSERT_TRUE(old->send({.type = -6, .dest = Address(1), .src = Address(2)}, body).ok());
    const auto back = native.peek_for(kPatience);
    ASSERT_TRUE(back.ok());
    EXPECT_TRUE(std::ranges::equal(back->body(), body));
  }
  EXPECT_EQ(native.send({.dest = Address(2)}, std::vector<std::byte>(16U << 20)).error().code(),
            Errc::kTooBig);
}

TEST_F(LocalTest, OrderHoldsWhenAReceiverMovesFromTcpToThisHost) {
  Session s = session();
  Session t = session();
  Mailbox sender = open(s, 1);
  auto old = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(old.ok());
  ASSERT_TRUE(old->register_mailbox(Address(2)).ok());
  ASSERT_TRUE(send(sender, 2, "to tcp").ok());
  const auto first = old->receive();
  ASSERT_TRUE(first.ok());
  ASSERT_TRUE(old->delete_mailbox(Address(2)).ok());
  Mailbox native = open(t, 2, {.slots = 1000});
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(send(sender, 2, std::to_string(i)).ok());
  for (int i = 0; i < 500; ++i) ASSERT_EQ(receive(native), std::to_string(i));
}

// --- the default router

// Removes an environment variable during its lifetime.
class Without {
 public:
  explicit Without(const char* name) : name_(name) {
    if (const char* value = std::getenv(name)) before_ = value;
    ::unsetenv(name);
  }
  Without(const Without&) = delete;
  Without& operator=(const Without&) = delete;
  ~Without() {
    if (before_) ::setenv(name_, before_->c_str(), 1);
  }

 private:
  const char* name_;
  std::optional<std::string> before_;
};

TEST(DefaultRouter, IsTheUsersOwnInTmpButNotOfAnotherUser) {
  const Without router("TIMS_ROUTER");
  const Without runtime("XDG_RUNTIME_DIR");
  const std::filesystem::path folder = "/tmp/tims-" + std::to_string(::geteuid());
  if (std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is in use";
  EXPECT_EQ(default_router(), "/run/tims/router.sock");
  ASSERT_TRUE(std::filesystem::create_directory(folder));
  EXPECT_EQ(default_router(), "/run/tims/router.sock");
  std::ofstream(folder / "router.sock") << "";
  EXPECT_EQ(default_router(), folder / "router.sock");
  if (::chown(folder.c_str(), 65534, 65534) == 0) {
    EXPECT_EQ(default_router(), "/run/tims/router.sock");
  }
  std::filesystem::remove_all(folder);
}

}  // namespace local_test
}  // namespace tims::test
