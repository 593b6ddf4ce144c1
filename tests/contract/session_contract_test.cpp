// Requirements of a session and its mailboxes, for routers reached by shared memory and over TCP:
// the same calls, the same order, the same errors.
#include <atomic>
#include <cstring>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <poll.h>

#include "tests/support/eventually.h"
#include "tests/system/local_fixture.h"
#include "tims/address.h"
#include "tims/origin.h"

namespace tims::test {
namespace session_contract_test {

enum class Transport : std::uint8_t { kSharedMemory, kTcp };

class SessionContract : public LocalTest, public testing::WithParamInterface<Transport> {
 protected:
  Session session(SessionOptions options = {.name = "test"}) {
    options.router = place();
    options.timeout = kPatience;
    if (!options.on_event) options.on_event = [](const SessionEvent&) {};
    auto connected = Session::connect(std::move(options));
    EXPECT_TRUE(connected.ok()) << connected.error().message();
    return std::move(*connected);
  }
  std::string place() {
    return GetParam() == Transport::kTcp ? router_.tcp() : "unix:" + router_.socket_path();
  }
  // Sends, and waits until the message is in the mailbox, which takes some time over TCP.
  static void put(Mailbox& from, Mailbox& to, const std::string& text, std::uint8_t priority) {
    const auto before = to.counters();
    ASSERT_TRUE(send(from, to.address().raw(), text, priority).ok());
    ASSERT_TRUE(eventually(
        [&] {
          const auto now = to.counters();
          return now.waiting > before.waiting || now.replaced > before.replaced;
        },
        text));
  }
};

// --- Messages

TEST_P(SessionContract, HeadersArriveAsTheyWereSentAndRepliesGoBack) {
  Session one = session();
  Session two = session();
  EXPECT_TRUE(one.connected());
  EXPECT_EQ(one.address_widths(), AddressWidths());
  Mailbox client = open(one, 0x00180101);
  Mailbox server = open(two, 0x00140000);
  ASSERT_TRUE(client.send({.dest = server.address(), .type = 4, .priority = 30, .seq_nr = 200},
                          bytes_of("ask")));
  const auto request = server.peek_for(kPatience);
  ASSERT_TRUE(request.ok()) << request.error().message();
  const Header expected{.flags = flag::kNativeOrder,
                        .type = 4,
                        .priority = 30,
                        .seq_nr = 200,
                        .dest = server.address(),
                        .src = client.address(),
                        .length = kHeaderSize + 3};
  EXPECT_EQ(marked_foreign(request->header(), false), expected);
  EXPECT_EQ(is_foreign(request->header()), GetParam() == Transport::kTcp);
  EXPECT_EQ(text_of(request->body()), "ask");
  ASSERT_TRUE(server.reply(request->header(), type::kData, bytes_of("data")));
  const auto reply = client.peek_for(kPatience);
  ASSERT_TRUE(reply.ok());
  EXPECT_EQ(reply->header().type, type::kData);
  EXPECT_EQ(reply->header().priority, 30);
  EXPECT_EQ(reply->header().seq_nr, 200);
  EXPECT_EQ(reply->header().src, server.address());
  EXPECT_EQ(text_of(reply->body()), "data");
}

TEST_P(SessionContract, MailboxesOfOneSessionAndOfSeveralExchangeMessages) {
  Session s = session();
  Session t = session();
  Mailbox a = open(s, 1);
  Mailbox b = open(s, 2);
  Mailbox c = open(t, 3);
  ASSERT_TRUE(send(a, 2, "within a session"));
  EXPECT_EQ(receive(b), "within a session");
  ASSERT_TRUE(send(a, 1, "to itself"));
  EXPECT_EQ(receive(a), "to itself");
  ASSERT_TRUE(send(a, 3, "between sessions"));
  EXPECT_EQ(receive(c), "between sessions");
}

TEST_P(SessionContract, HigherPriorityComesFirstAndReplacesTheLowest) {
  Session s = session();
  Mailbox a = open(s, 1);
  Mailbox b = open(s, 2, {.slots = 3});
  put(a, b, "low", 1);
  put(a, b, "high", 200);
  put(a, b, "high too", 200);
  put(a, b, "highest", 255);
  EXPECT_EQ(b.counters().replaced, 1U);
  EXPECT_EQ(receive(b), "highest");
  EXPECT_EQ(receive(b), "high");
  EXPECT_EQ(receive(b), "high too");
  EXPECT_EQ(b.try_peek().error().code(), Errc::kEmpty);
}

TEST_P(SessionContract, RefusedMessagesAreCounted) {
  Session s = session();
  Mailbox a = open(s, 1);
  Mailbox b = open(s, 2, {.slots = 1, .body_max = 10});
  (void)send(a, 2, "more than ten bytes");
  EXPECT_TRUE(eventually([&] { return b.counters().too_big == 1; }, "too big"));
  put(a, b, "first", 5);
  (void)send(a, 2, "second", 4);
  EXPECT_TRUE(eventually([&] { return b.counters().refused == 1; }, "refused"));
  EXPECT_EQ(receive(b), "first");
}

TEST_P(SessionContract, ACommandWithoutReceiverIsAnswered) {
  Session s = session();
  Mailbox a = open(s, 1);
  ASSERT_TRUE(a.send({.dest = Address(99), .type = 21, .seq_nr = 4}));
  const auto answer = a.peek_for(kPatience);
  ASSERT_TRUE(answer.ok());
  EXPECT_EQ(answer->header().type, type::kNotAvailable);
  EXPECT_EQ(answer->header().src, Address(99));
  EXPECT_EQ(answer->header().seq_nr, 4);
}

TEST_P(SessionContract, AClosedMailboxIsNotAvailableAndIsFoundAgain) {
  Session s = session();
  Session t = session();
  Mailbox a = open(s, 1);
  for (int round = 0; round < 3; ++round) {
    std::optional<Mailbox> b = open(t, 2);
    ASSERT_TRUE(send(a, 2, "here"));
    EXPECT_EQ(receive(*b), "here");
    b.reset();
    ASSERT_TRUE(send(a, 2, "nobody"));
    const auto answer = a.peek_for(kPatience);
    ASSERT_TRUE(answer.ok());
    EXPECT_EQ(answer->header().type, type::kNotAvailable);
    EXPECT_EQ(answer->header().src, Address(2));
  }
}

TEST_P(SessionContract, MessagesSentBeforeTheSessionEndsArrive) {
  Session near = session();
  Mailbox b = open(near, 2, {.slots = 1000});
  {
    Session s = session();
    Mailbox a = open(s, 1);
    for (int i = 0; i < 900; ++i) ASSERT_TRUE(send(a, 2, std::to_string(i)));
  }
  for (int i = 0; i < 900; ++i) ASSERT_EQ(receive(b), std::to_string(i));
}

// The receiver is a client on TCP, so the router must deliver the messages.
TEST_P(SessionContract, MessagesSentThroughTheRouterBeforeTheSessionEndsArrive) {
  auto far = TcpClient::connect(router_.tcp());
  ASSERT_TRUE(far.ok() && far->register_mailbox(Address(2)).ok());
  {
    Session s = session();
    Mailbox a = open(s, 1);
    for (int i = 0; i < 900; ++i) ASSERT_TRUE(send(a, 2, std::to_string(i)));
  }
  for (int i = 0; i < 900; ++i) {
    const auto message = far->receive();
    ASSERT_TRUE(message.ok()) << "number " << i << ": " << message.error().message();
    ASSERT_EQ(text_of(message->body), std::to_string(i));
  }
}

// --- Receiving

TEST_P(SessionContract, WaitingEndsAtItsTimeoutAndNotBefore) {
  Session s = session();
  Mailbox a = open(s, 1);
  std::vector<std::byte> buffer(64);
  EXPECT_EQ(a.try_receive(buffer).error().code(), Errc::kEmpty);
  const auto before = std::chrono::steady_clock::now();
  EXPECT_EQ(a.receive_for(buffer, 30ms).error().code(), Errc::kTimeout);
  EXPECT_GE(std::chrono::steady_clock::now() - before, 30ms);
  EXPECT_EQ(a.receive_for(buffer, Duration::zero()).error().code(), Errc::kTimeout);
}

TEST_P(SessionContract, AMessageLargerThanTheBufferStaysInTheMailbox) {
  Session s = session();
  Mailbox a = open(s, 1);
  put(a, a, "0123456789", 0);
  std::vector<std::byte> small(9);
  std::vector<std::byte> enough(10);
  EXPECT_EQ(a.try_receive(small).error().code(), Errc::kBufferTooSmall);
  const auto got = a.try_receive(enough);
  ASSERT_TRUE(got.ok());
  EXPECT_EQ(text_of(got->body), "0123456789");
}

TEST_P(SessionContract, ManyThreadsReceiveEachMessageOnce) {
  Session s = session();
  Mailbox a = open(s, 1);
  Mailbox b = open(s, 2, {.slots = 1010});
  constexpr int kMessages = 1000;
  std::vector<std::atomic<int>> seen(kMessages);
  std::atomic<int> total = 0;
  std::vector<std::thread> readers;
  readers.reserve(4);
  for (int i = 0; i < 4; ++i)
    readers.emplace_back([&] {
      for (;;) {
        const std::string text = receive(b);
        if (text == "end") return;
        ++seen[static_cast<std::size_t>(std::stoi(text))];
        ++total;
      }
    });
  for (int i = 0; i < kMessages; ++i) ASSERT_TRUE(send(a, 2, std::to_string(i)).ok());
  EXPECT_TRUE(eventually([&] { return total == kMessages; }, "every message received"));
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(send(a, 2, "end").ok());
  for (std::thread& reader : readers) reader.join();
  for (const auto& count : seen) EXPECT_EQ(count, 1);
}

TEST_P(SessionContract, AMessageWakesItsReaderAndItsDescriptor) {
  Session s = session();
  Mailbox a = open(s, 1);
  Mailbox b = open(s, 2, {.event_fd = true});
  EXPECT_EQ(a.event_fd(), -1);
  EXPECT_EQ(b.try_peek().error().code(), Errc::kEmpty);  // arms the descriptor
  for (int round = 0; round < 20; ++round) {
    ASSERT_TRUE(send(a, 2, "x"));
    pollfd wait{b.event_fd(), POLLIN, 0};
    ASSERT_EQ(::poll(&wait, 1, kPatienceMs), 1) << round;
    EXPECT_EQ(receive(b), "x");
    EXPECT_EQ(b.try_peek().error().code(), Errc::kEmpty);
  }
  std::thread sender([&] { EXPECT_TRUE(send(a, 2, "blocking works too")); });
  EXPECT_EQ(receive(b), "blocking works too");
  sender.join();
}

TEST_P(SessionContract, CleanDiscardsWaitingMessages) {
  Session s = session();
  Mailbox a = open(s, 1);
  for (int i = 0; i < 3; ++i) put(a, a, "x", 0);
  EXPECT_EQ(a.clean(), 3U);
  EXPECT_EQ(receive(a, 0ns), "timeout");
}

// --- Loans

TEST_P(SessionContract, LoansAreSentAndDroppedLoansHaveNoEffect) {
  Session s = session();
  Mailbox a = open(s, 1);
  Mailbox b = open(s, 2, {.slots = 1});
  for (int i = 0; i < 100; ++i) {
    auto dropped = a.loan({.dest = Address(2)}, 4);
    ASSERT_TRUE(dropped.ok()) << dropped.error().message();
  }
  auto loan = a.loan({.dest = Address(2), .type = 5}, 4);
  ASSERT_TRUE(loan.ok());
  std::memcpy(loan->body().data(), "abcd", 4);
  EXPECT_EQ(b.try_peek().error().code(), Errc::kEmpty);
  ASSERT_TRUE(loan->send().ok());
  EXPECT_EQ(receive(b), "abcd");
}

// --- Owners

// The class is named by this program; the router may not know it.
TEST_P(SessionContract, ARefusalNamesTheClassAsThisProgramDoes) {
  (void)name_class(0xEE, "Thermometer");
  Session first = session({.name = "probe"});
  Session second = session({.name = "impostor"});
  std::optional<Mailbox> owner = open(first, 0x00EE0000);
  const auto refused = second.open({.address = Address(0x00EE0000)});
  ASSERT_FALSE(refused.ok());
  EXPECT_TRUE(refused.error().detail().starts_with("Thermometer(0/0) belongs to "))
      << refused.error().detail();
}

TEST_P(SessionContract, AnAddressHasOneOwner) {
  Session first = session({.name = "laser"});
  Session second = session({.name = "impostor"});
  std::optional<Mailbox> owner = open(first, 0x00140000);
  const auto refused = second.open({.address = Address(0x00140000)});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code(), Errc::kAddressInUse);
  EXPECT_NE(refused.error().message().find("Ladar(0/0)"), std::string::npos)
      << refused.error().message();
  EXPECT_EQ(first.open({.address = Address(0x00140000)}).error().code(), Errc::kAddressInUse);
  Mailbox sender = open(second, 7);
  ASSERT_TRUE(send(sender, 0x00140000, "still there"));
  EXPECT_EQ(receive(*owner), "still there");
  owner.reset();
  Mailbox successor = open(second, 0x00140000);
  ASSERT_TRUE(send(sender, 0x00140000, "to the next owner"));
  EXPECT_EQ(receive(successor), "to the next owner");
}

TEST_P(SessionContract, OpeningManyIsAllOrNone) {
  Session first = session();
  Session second = session();
  Mailbox taken = open(first, 5);
  std::vector<MailboxOptions> options(10);
  for (std::uint32_t i = 0; i < 10; ++i) options[i].address = Address(i);
  EXPECT_EQ(second.open(options).error().code(), Errc::kAddressInUse);
  Mailbox free = open(first, 4);  // was not opened by the failed call
  options.erase(options.begin() + 4, options.begin() + 6);
  EXPECT_TRUE(second.open(options).ok());
}

// --- Restarted routers

TEST_P(SessionContract, AReconnectMakesAWorkingSession) {
  Session s = session();
  Session t = session();
  Mailbox a = open(s, 1);
  Mailbox b = open(t, 2);
  for (int round = 0; round < 3; ++round) {
    ASSERT_TRUE(send(a, 2, "before"));
    EXPECT_EQ(receive(b), "before");
    router_.kill();
    EXPECT_TRUE(eventually([&] { return !s.connected() && !t.connected(); }, "router missed"));
    EXPECT_EQ(send(a, 99, "x").error().code(), Errc::kNoRouter);
    // Shared memory reaches a known mailbox without the router; TCP reports the error at once.
    const auto known = send(a, 2, "without router");
    if (GetParam() == Transport::kSharedMemory) {
      EXPECT_EQ(receive(b), "without router");
    } else {
      EXPECT_EQ(known.error().code(), Errc::kNoRouter);
    }
    ASSERT_TRUE(router_.start().ok());
    EXPECT_TRUE(eventually([&] { return s.connected() && t.connected(); }, "both back"));
    ASSERT_TRUE(send(a, 2, "after"));
    EXPECT_EQ(receive(b), "after");
    auto old = TcpClient::connect(router_.tcp());
    ASSERT_TRUE(old.ok());
    ASSERT_TRUE(
        old->send({.type = 21, .dest = Address(2), .src = Address(7)}, bytes_of("tcp")).ok());
    EXPECT_EQ(receive(b), "tcp");  // registered again
  }
}

TEST_P(SessionContract, AMailboxTakenByAnotherClientAfterARestartIsReported) {
  std::atomic<bool> lost = false;
  Session s = session({.on_event = [&](const SessionEvent& event) {
    if (event.kind == SessionEvent::Kind::kMailboxLost) lost = true;
  }});
  std::optional<Mailbox> a = open(s, 1);
  // After the restart another client registers the address first.
  std::optional<TcpClient> other;
  for (bool first = false; !first;) {
    router_.kill();
    ASSERT_TRUE(router_.start().ok());
    auto client = TcpClient::connect(router_.tcp());
    ASSERT_TRUE(client.ok());
    other.emplace(std::move(*client));
    first = other->register_mailbox(Address(1)).ok();
  }
  EXPECT_TRUE(eventually([&] { return lost.load(); }, "the loss is reported"));
  // Closing the lost mailbox does not affect its new owner.
  a.reset();
  Mailbox b = open(s, 2);
  ASSERT_TRUE(send(b, 1, "yours"));
  const auto message = other->receive();
  ASSERT_TRUE(message.ok());
  EXPECT_EQ(text_of(message->body), "yours");
}

TEST_P(SessionContract, WithoutARouterConnectTimesOutAndNamesTheEndpoint) {
  router_.kill();
  const auto refused = Session::connect(
      {.router = place(), .timeout = 50ms, .on_event = [](const SessionEvent&) {}});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code(), Errc::kTimeout);
  const std::string where =
      GetParam() == Transport::kTcp ? router_.tcp() : std::string(router_.socket_path());
  EXPECT_NE(refused.error().message().find(where), std::string::npos) << refused.error().message();
}

INSTANTIATE_TEST_SUITE_P(Transports, SessionContract,
                         testing::Values(Transport::kSharedMemory, Transport::kTcp),
                         [](const testing::TestParamInfo<Transport>& transport) {
                           return transport.param == Transport::kTcp ? "Tcp" : "SharedMemory";
                         });

}  // namespace session_contract_test
}  // namespace tims::test
