// Sessions with a router over TCP: the same calls, the same order, the same errors.
#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <poll.h>
#include <sched.h>
#include <sys/resource.h>

#include "os/clock.h"
#include "rack/proxies/chassis.h"
#include "tests/support/eventually.h"
#include "tests/support/tcp_socket.h"
#include "tests/system/local_fixture.h"

namespace tims::test {
namespace tcp_session_test {

constexpr std::uint32_t kTcpMax = 256 << 10;  // default limit, header included

class TcpSessionTest : public LocalTest {
 protected:
  Session tcp_session(SessionOptions options = {}) {
    options.name = "far";
    options.router = router_.tcp();
    options.timeout = kPatience;
    if (!options.on_event) options.on_event = [](const SessionEvent&) {};
    auto connected = Session::connect(std::move(options));
    EXPECT_TRUE(connected.ok()) << connected.error().message();
    return std::move(*connected);
  }
};

TEST_F(TcpSessionTest, ExchangesMessagesWithMailboxesOfTheRoutersHost) {
  Session far = tcp_session();
  Session near = session();
  EXPECT_TRUE(far.connected());
  EXPECT_EQ(far.router(), Address());
  EXPECT_EQ(far.address_widths(), AddressWidths());
  Mailbox a = open(far, 1);
  Mailbox b = open(near, 2);
  ASSERT_TRUE(a.send({.dest = Address(2), .type = 21, .priority = 3, .seq_nr = 7}, bytes_of("hi")));
  auto request = b.peek_for(kPatience);
  ASSERT_TRUE(request.ok());
  EXPECT_EQ(text_of(request->body()), "hi");
  EXPECT_EQ(request->header().src, Address(1));
  ASSERT_TRUE(b.reply(request->header(), type::kOk, bytes_of("ho")));
  const auto answer = a.peek_for(kPatience);
  ASSERT_TRUE(answer.ok());
  EXPECT_EQ(text_of(answer->body()), "ho");
  EXPECT_EQ(answer->header().priority, 3);
  EXPECT_EQ(answer->header().seq_nr, 7);
}

// Peak memory of this process in bytes.
std::size_t most_memory() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) << 10;
}

// Closing waits for messages sent before, but not for those that others send at the same time.
TEST_F(TcpSessionTest, ClosingUsesNoMoreMemoryThanAnUplinkHolds) {
  Session s = tcp_session();
  std::atomic<bool> done = false;
  std::vector<std::thread> senders;
  for (std::uint32_t i = 0; i < 3; ++i) {
    senders.emplace_back([&, i] {
      const Mailbox unused = open(s, 20 + i);
      Mailbox from = open(s, 10 + i);
      const std::vector<std::byte> much(kTcpMax - kHeaderSize);
      while (!done) (void)from.send({.dest = Address(2), .type = -6}, much);
    });
  }
  std::size_t before = 0;
  for (int round = 0; round < 20; ++round) {
    {
      const Mailbox closed = open(s, 1);
    }
    if (round == 0) before = most_memory();
  }
  done = true;
  for (std::thread& sender : senders) sender.join();
  if (kSlowdown == 1) {  // sanitizers keep freed memory
    EXPECT_LT(most_memory() - before, 32U << 20);
  }
}

TEST_F(TcpSessionTest, AMessageMayBeAsLargeAsTheLimit) {
  Session s = tcp_session();
  Mailbox a = open(s, 1);
  Mailbox b = open(s, 2, {.body_max = 1 << 20});
  const std::string largest(kTcpMax - kHeaderSize, 'x');
  for (int i = 0; i < 20; ++i) {  // more than the uplink has slots
    ASSERT_TRUE(send(a, 2, largest));
    EXPECT_EQ(receive(b), largest);
  }
  EXPECT_EQ(send(a, 2, largest + "x").error().code(), Errc::kTooBig);
  EXPECT_TRUE(s.connected());
  Session larger = tcp_session({.tcp_message_max = 1 << 20});
  Mailbox c = open(larger, 3);
  ASSERT_TRUE(send(c, 2, largest + "x"));
  EXPECT_EQ(receive(b), largest + "x");
}

TEST_F(TcpSessionTest, AnAddressHasOneOwner) {
  Session s = tcp_session();
  Session t = tcp_session();
  std::optional<Mailbox> a = open(s, 1);
  const auto taken = t.open({.address = Address(1)});
  ASSERT_FALSE(taken.ok());
  EXPECT_EQ(taken.error().code(), Errc::kAddressInUse);
  EXPECT_NE(taken.error().detail().find(router_.tcp()), std::string::npos);
  EXPECT_EQ(s.open({.address = Address(1)}).error().code(), Errc::kAddressInUse);
  // All or none.
  const std::vector<MailboxOptions> both{{.address = Address(7)}, {.address = Address(1)}};
  EXPECT_EQ(t.open(both).error().code(), Errc::kAddressInUse);
  Mailbox b = open(t, 7);
  ASSERT_TRUE(send(b, 1, "still there"));
  EXPECT_EQ(receive(*a), "still there");
  a.reset();
  Mailbox successor = open(t, 1);
  ASSERT_TRUE(send(b, 1, "to the next owner"));
  EXPECT_EQ(receive(successor), "to the next owner");
}

TEST_F(TcpSessionTest, AStoppedRouterDoesNotBlockSendersForLong) {
  Session s = tcp_session();
  Mailbox a = open(s, 1);
  const std::string large(100'000, 'x');
  ASSERT_TRUE(send(a, 1, "so that the route is known"));
  EXPECT_EQ(receive(a), "so that the route is known");
  router_.process().signal(SIGSTOP);
  Errc outcome = Errc::kEmpty;
  while (outcome != Errc::kFull) {  // fills the sockets and the uplink
    const Time begin = os::now();
    const auto sent = send(a, 1, large);
    EXPECT_LT(os::now() - begin, 200ms + kPatience / 10);
    if (!sent) outcome = sent.error().code();
    ASSERT_TRUE(sent.ok() || outcome == Errc::kFull) << sent.error().message();
  }
  router_.process().signal(SIGCONT);
  EXPECT_TRUE(eventually([&] { return send(a, 1, "again").ok(); }, "room again"));
}

TEST_F(TcpSessionTest, LifesignsAreAnswered) {
  router_.kill();
  RouterProcess strict({lifesign_interval(100ms)});
  const auto started = strict.start();
  ASSERT_TRUE(started.ok()) << started.error().message();
  std::atomic<int> lost = 0;
  auto s = Session::connect({.router = strict.tcp(), .on_event = [&](const SessionEvent& event) {
                               if (event.kind == SessionEvent::Kind::kLost) ++lost;
                             }});
  ASSERT_TRUE(s.ok());
  auto silent = TcpClient::connect(strict.tcp());
  ASSERT_TRUE(silent.ok());
  silent->set_answers_lifesigns(false);
  EXPECT_TRUE(silent->wait_for_close().ok());
  EXPECT_EQ(lost, 0);
  EXPECT_TRUE(s->connected());
}

TEST_F(TcpSessionTest, InvalidEndpointsAreRefused) {
  const auto refused = Session::connect({.router = "robot:x"});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code(), Errc::kInvalidArgument);
  const auto nobody =
      Session::connect({.router = "127.0.0.1:1", .timeout = 50ms, .on_event = [](const auto&) {}});
  ASSERT_FALSE(nobody.ok());
  EXPECT_EQ(nobody.error().code(), Errc::kTimeout);
  EXPECT_NE(nobody.error().message().find("127.0.0.1:1"), std::string::npos);
}

bool may_be_real_time(int priority) {
  bool may = false;
  std::thread([&] {
    const sched_param wanted{.sched_priority = priority};
    may = ::sched_setscheduler(0, SCHED_FIFO, &wanted) == 0;
  }).join();
  return may;
}

// The real-time priority of the thread with that name; 0: not real-time, or no such thread.
int priority_of(pid_t process, const std::string& thread) {
  for (const auto& task :
       std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task")) {
    std::string name;
    std::ifstream(task.path() / "comm") >> name;
    const pid_t id = std::stoi(task.path().filename());
    sched_param param{};
    if (name == thread && ::sched_getscheduler(id) == SCHED_FIFO &&
        ::sched_getparam(id, &param) == 0)
      return param.sched_priority;
  }
  return 0;
}

// With an ordinary sending thread, messages of its tasks would wait for 100 ms or more on a busy
// machine.
TEST_F(TcpSessionTest, ARealTimeComponentSendsInRealTime) {
  if (!may_be_real_time(30)) GTEST_SKIP() << "needs the right to real-time priorities";
  for (const int priority : {1, 29}) {
    auto chassis = ChildProcess::start({TIMS_PROGRAMS "/ChassisSim", "--router", router_.tcp(),
                                        "--dataTaskPrio", std::to_string(priority)});
    ASSERT_TRUE(chassis.ok());
    ASSERT_TRUE(chassis->wait_for_line("Init"));
    EXPECT_EQ(priority_of(chassis->pid(), "tims-tcp"), priority == 1 ? 0 : priority);
    EXPECT_TRUE(chassis->stop(SIGTERM));
  }
}

TEST_F(TcpSessionTest, AComponentNeedsNoRouterOnItsHost) {
  auto chassis = ChildProcess::start({TIMS_PROGRAMS "/ChassisSim", "--router", router_.tcp()});
  ASSERT_TRUE(chassis.ok());
  Session s = session();
  Mailbox work = open(s, 0x00180101);
  rack::ChassisProxy proxy(work, Address(0x00110000),
                           {.on = kPatience, .off = kPatience, .data = kPatience});
  ASSERT_TRUE(eventually([&] { return proxy.status().ok(); }, "a chassis"));
  ASSERT_TRUE(proxy.on());
  const auto data = proxy.get_data();
  EXPECT_TRUE(data.ok()) << data.error().message();
  const auto status = chassis->stop(SIGTERM);
  ASSERT_TRUE(status.ok()) << status.error().message();
  EXPECT_TRUE(status->success()) << chassis->output();
}

}  // namespace tcp_session_test
}  // namespace tims::test
