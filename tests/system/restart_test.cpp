// The router may be restarted, or start late: components keep running.
#include <atomic>
#include <chrono>
#include <csignal>
#include <optional>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "tests/support/eventually.h"
#include "tests/system/local_fixture.h"

namespace tims::test {
namespace restart_test {

class RestartTest : public LocalTest {};

TEST_F(RestartTest, TheRouterMayBeKilledAndRestarted) {
  Session s = session();
  Session t = session();
  Mailbox a = open(s, 1);
  Mailbox b = open(t, 2);
  ASSERT_TRUE(send(a, 2, "before").ok());
  EXPECT_EQ(receive(b), "before");

  router_.kill();
  EXPECT_TRUE(eventually([&] { return !s.connected() && !t.connected(); }, "router missed"));
  ASSERT_TRUE(send(a, 2, "without a router").ok());  // the mailboxes know each other
  EXPECT_EQ(receive(b), "without a router");
  EXPECT_EQ(send(a, 99, "x").error().code(), Errc::kNoRouter);

  ASSERT_TRUE(router_.start().ok());
  EXPECT_TRUE(eventually([&] { return s.connected() && t.connected(); }, "both back"));
  ASSERT_TRUE(send(a, 2, "after").ok());
  EXPECT_EQ(receive(b), "after");
  auto old = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(old.ok());
  ASSERT_TRUE(old->send({.type = 21, .dest = Address(2), .src = Address(7)}, bytes_of("tcp")).ok());
  EXPECT_EQ(receive(b), "tcp");  // registered again
}

TEST_F(RestartTest, AnOwnerKilledWhileNoRouterRanIsDetected) {
  Session s = session();
  std::optional<Session> t = session();
  Mailbox a = open(s, 1);
  std::optional<Mailbox> b = open(*t, 2);
  ASSERT_TRUE(send(a, 2, "x").ok());
  router_.kill();
  EXPECT_TRUE(eventually([&] { return !t->connected(); }, "router missed"));
  b.reset();
  t.reset();
  ASSERT_TRUE(router_.start().ok());
  EXPECT_TRUE(eventually(
      [&] {
        (void)send(a, 2, "anybody there?");
        const auto answer = a.try_peek();
        return answer && answer->header().type == type::kNotAvailable;
      },
      "NOT_AVAILABLE"));
}

// Senders that know a mailbox of this host do not wait for the router, however slow it is.
TEST_F(RestartTest, ARouterStoppedAfterARestartDoesNotBlockKnownRoutes) {
  Session s = session();
  Session t = session();
  Mailbox a = open(s, 1);
  Mailbox b = open(t, 2);
  auto tcp = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(tcp.ok() && tcp->register_mailbox(Address(7)).ok());
  ASSERT_TRUE(send(a, 2, "before").ok());
  EXPECT_EQ(receive(b), "before");
  ASSERT_TRUE(send(a, 7, "before").ok());
  router_.kill();
  EXPECT_TRUE(eventually([&] { return !s.connected() && !t.connected(); }, "router missed"));
  ASSERT_TRUE(router_.start().ok());
  EXPECT_TRUE(eventually([&] { return s.connected() && t.connected(); }, "both back"));
  router_.process().signal(SIGSTOP);
  std::thread first_use([&] { (void)send(b, 8, "unknown"); });  // only this one waits
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 300; ++i) {
    EXPECT_TRUE(send(a, 2, "local").ok());
    EXPECT_EQ(receive(b), "local");
    EXPECT_TRUE(send(a, 7, "through the router").ok());
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, kPatience);  // a wait for each: 25 minutes
  router_.process().signal(SIGCONT);
  first_use.join();
}

TEST_F(RestartTest, ProgramsMayStartBeforeTheRouter) {
  router_.kill();
  std::atomic<bool> waiting = false;
  std::thread later([&] {
    EXPECT_TRUE(eventually([&] { return waiting.load(); }, "the program reports that it waits"));
  });
  std::optional<Result<Session>> connected;
  std::thread program([&] {
    connected.emplace(Session::connect({.name = "early",
                                        .router = router_.socket_path(),
                                        .timeout = kPatience,
                                        .on_event = [&](const SessionEvent& e) {
                                          if (e.kind == SessionEvent::Kind::kWaiting)
                                            waiting = true;
                                        }}));
  });
  later.join();
  ASSERT_TRUE(router_.start().ok());
  program.join();
  EXPECT_TRUE(connected->ok());
}

}  // namespace restart_test
}  // namespace tims::test
