// A running client that the router has disconnected or kept waiting: it works again after it has
// reconnected.
#include <atomic>
#include <csignal>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <sys/socket.h>

#include "os/shared_memory.h"
#include "shm/layout.h"
#include "shm/receiver.h"
#include "tests/support/eventually.h"
#include "tests/system/local_fixture.h"
#include "tests/system/raw_client.h"

namespace tims::test {
namespace reconnect_test {

class ReconnectTest : public LocalTest {
 protected:
  // Like session(), but counts its connections.
  Session counted(const std::string& name = "test") {
    auto connected = Session::connect({.name = name,
                                       .router = router_.socket_path(),
                                       .timeout = kPatience,
                                       .on_event = [this](const SessionEvent& e) {
                                         if (e.kind == SessionEvent::Kind::kConnected) ++connected_;
                                         if (e.kind == SessionEvent::Kind::kMailboxLost) ++lost_;
                                       }});
    EXPECT_TRUE(connected.ok()) << connected.error().message();
    return std::move(*connected);
  }
  // Breaks every connection of this program to the router, as if the router had closed it.
  void break_connections() {
    const pid_t router = router_.process().pid();
    for (int fd = 3; fd < 1024; ++fd)
      if (os::peer_credentials(fd).pid == router) ::shutdown(fd, SHUT_RDWR);
  }
  // The number of mailboxes that receive messages of `from`.
  static std::size_t reached(Mailbox& from, std::vector<Mailbox>& mailboxes) {
    std::size_t count = 0;
    for (Mailbox& mailbox : mailboxes) {
      const auto sent = from.send({.dest = mailbox.address(), .type = 21});
      count += sent.ok() && mailbox.peek_for(kPatience / 20).ok() ? 1 : 0;
    }
    return count;
  }

  std::atomic<std::size_t> connected_ = 0;
  std::atomic<std::size_t> lost_ = 0;
};

TEST_F(ReconnectTest, ClientsDroppedByTheRouterAreReachedAgain) {
  constexpr std::size_t kCount = 20;
  std::vector<Session> sessions;
  std::vector<Mailbox> mailboxes;
  for (std::uint32_t i = 0; i < kCount; ++i) {
    sessions.push_back(counted());
    mailboxes.push_back(open(sessions.back(), 100 + i));
  }
  Session other = counted();
  Mailbox sender = open(other, 1);
  EXPECT_EQ(reached(sender, mailboxes), kCount);
  std::size_t expected = kCount + 1;
  for (int round = 0; round < 3; ++round) {
    break_connections();
    expected += kCount + 1;
    ASSERT_TRUE(eventually([&] { return connected_ >= expected; }, "all connected again"));
    EXPECT_EQ(reached(sender, mailboxes), kCount);
  }
  router_.kill();
  ASSERT_TRUE(router_.start().ok());
  expected += kCount + 1;
  ASSERT_TRUE(eventually([&] { return connected_ >= expected; }, "at another router"));
  EXPECT_EQ(reached(sender, mailboxes), kCount);
  EXPECT_EQ(lost_, 0U);
}

// Messages sent while the router is stopped are delivered by its successor if it is killed.
TEST_F(ReconnectTest, MessagesForAKilledRouterGoToItsSuccessor) {
  constexpr int kCount = 1000;
  Session s = counted();
  Mailbox sender = open(s, 1, {.slots = 2 * kCount});
  // The address has no owner, so the router answers each message.
  const auto send_one = [&](int i) {
    return sender.send({.dest = Address(0x63140000),
                        .type = 21,
                        .seq_nr = static_cast<std::uint8_t>(i),
                        .report_if_gone = true},
                       bytes_of(std::string(i % 20 == 0 ? 20'000 : 10, 'x')));
  };
  ASSERT_TRUE(send_one(0).ok());
  ASSERT_TRUE(sender.peek_for(kPatience).ok());
  router_.process().signal(SIGSTOP);
  for (int i = 1; i <= kCount; ++i) ASSERT_TRUE(send_one(i).ok()) << i;
  router_.kill();
  ASSERT_TRUE(router_.start().ok());
  for (int i = 0; i < kCount; ++i) {
    const auto answer = sender.peek_for(kPatience);
    ASSERT_TRUE(answer.ok()) << i << " of " << kCount;
    ASSERT_EQ(answer->header().type, type::kNotAvailable);
  }
  EXPECT_FALSE(sender.peek_for(20ms).ok()) << "no message is answered twice";
}

// A mailbox created without libtims.
struct RawMailbox {
  os::File memfd = std::move(*os::make_memfd("raw", shm::Geometry::of(4, 80).bytes));
  os::Mapping mapping = std::move(*os::Mapping::of(memfd));
  shm::MailboxView view = shm::MailboxView::create(
      mapping.bytes(), 0, {.address = Address(5), .slots = 4, .message_max = 80});
};

// A client that gets no answer repeats its request; the router was only slow.
TEST_F(ReconnectTest, ARepeatedRequestIsNotAViolation) {
  const RawMailbox mailbox;
  RawClient client(router_.socket_path());
  ASSERT_TRUE(client.hello());
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(try_open(client, mailbox.memfd, 0), wire::OpenStatus::kOk) << i;
  Session s = session();
  Mailbox sender = open(s, 1);
  ASSERT_TRUE(send(sender, 5, "x").ok());
  EXPECT_EQ(shm::waiting(mailbox.view), 1U);
}

// The router may read the end of the first connection and the requests of the second in either
// order.
TEST_F(ReconnectTest, TheFormerConnectionIsNotAnotherOwner) {
  const RawMailbox mailbox;
  std::optional<RawClient> client(std::in_place, router_.socket_path());
  ASSERT_TRUE(client->hello());
  ASSERT_EQ(try_open(*client, mailbox.memfd, 0), wire::OpenStatus::kOk);
  for (int round = 0; round < 50; ++round) {
    std::optional<RawClient> next(std::in_place, router_.socket_path());
    ASSERT_TRUE(next->hello());
    router_.process().signal(SIGSTOP);
    ASSERT_TRUE(next->send(wire::OfferSegment{1}, {mailbox.memfd.get()}));
    ASSERT_TRUE(next->send(wire::Open{{{Address(5), {1, 0}, false}}}));
    client.reset();
    router_.process().signal(SIGCONT);
    const auto answer = next->receive();
    ASSERT_TRUE(answer && std::holds_alternative<wire::Opened>(*answer));
    ASSERT_EQ(std::get<wire::Opened>(*answer).entries.front().status, wire::OpenStatus::kOk);
    ASSERT_EQ(mailbox.view.header().closed.load(std::memory_order_acquire), 0U);
    client = std::move(next);
  }
}

// Without descriptors a call fails with the reason; existing clients are not affected.
TEST_F(ReconnectTest, ARouterWithoutDescriptorsRefusesAndKeepsItsClients) {
  Session s = counted();
  Session t = counted();
  Mailbox sender = open(s, 1);
  std::vector<Mailbox> mailboxes;
  mailboxes.push_back(open(t, 2));
  ASSERT_EQ(reached(sender, mailboxes), 1U);
  const pid_t router = router_.process().pid();
  limit_descriptors(router, 3);
  for (const bool event_fd : {false, true}) {
    const auto refused = t.open({.address = Address(3), .event_fd = event_fd});
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code(), Errc::kRefused);
    EXPECT_NE(refused.error().message().find("descriptor"), std::string::npos)
        << refused.error().message();
  }
  EXPECT_EQ(reached(sender, mailboxes), 1U);
  limit_descriptors(router, 1024);
  mailboxes.push_back(open(t, 3));
  EXPECT_EQ(reached(sender, mailboxes), 2U);
  EXPECT_EQ(connected_, 2U);
}

// A client may use a quarter of the router's descriptors, so that others get theirs.
TEST_F(ReconnectTest, OneClientCannotTakeAllDescriptors) {
  constexpr std::size_t kShare = 30;
  limit_descriptors(router_.process().pid(), 4 * kShare);
  Session s = session();
  std::vector<Mailbox> mailboxes;
  for (std::uint32_t i = 0; mailboxes.size() < kShare / 2; ++i)
    mailboxes.push_back(open(s, 100 + i, {.event_fd = true}));  // two descriptors each
  for (const bool event_fd : {false, true}) {
    const auto refused = s.open({.address = Address(500), .event_fd = event_fd});
    ASSERT_FALSE(refused.ok());
    EXPECT_NE(refused.error().message().find("a quarter"), std::string::npos);
  }
  mailboxes.pop_back();
  mailboxes.push_back(open(s, 501));
  EXPECT_TRUE(s.open({.address = Address(502)}).ok());  // uses the descriptor that was released
  Session other = session();
  EXPECT_EQ(open(other, 1).address(), Address(1));
}

// New connections wait, and the router must not busy-wait during that time.
TEST_F(ReconnectTest, ARouterThatCannotAcceptSleeps) {
  const pid_t router = router_.process().pid();
  limit_descriptors(router, 3);
  const RawClient client(router_.socket_path());
  auto tcp = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(tcp.ok());
  int asleep = 0;
  EXPECT_TRUE(eventually(
      [&] {
        asleep = state_of(router) == 'S' ? asleep + 1 : 0;
        return asleep == 10;  // consecutive checks
      },
      "the router sleeps"));
  limit_descriptors(router, 1024);
  EXPECT_TRUE(tcp->register_mailbox(Address(9)).ok());
  EXPECT_NO_FATAL_FAILURE((void)session());
}

// Descriptors offered by a refused call are released.
TEST_F(ReconnectTest, ARefusedOpenReleasesEverything) {
  Session s = session();
  Session t = session();
  const Mailbox owner = open(s, 1);
  const Mailbox other = open(t, 2);
  const pid_t router = router_.process().pid();
  const std::size_t descriptors = descriptors_of(router);
  const std::size_t mappings = mappings_of(router);
  for (int i = 0; i < 50; ++i)
    EXPECT_EQ(t.open({.address = Address(1)}).error().code(), Errc::kAddressInUse);
  EXPECT_EQ(descriptors_of(router), descriptors);
  EXPECT_EQ(mappings_of(router), mappings);
}

}  // namespace reconnect_test
}  // namespace tims::test
