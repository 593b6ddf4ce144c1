// The original's commands and its watchdog (specification, sections 3.2 and 3.4).
#include "router/core/router_fixture.h"

namespace tims::core::test {
namespace router_commands_test {

using namespace std::chrono_literals;

TEST_F(RouterTest, InitWithReplyIsAnsweredOnTheConnection) {
  const ClientId a = connect();
  const ClientId b = connect();
  EXPECT_EQ(send_command(a, command::kMailboxInitWithReply, 0x00140000, 7, 42), Outcome::kHandled);
  EXPECT_EQ(send_command(b, command::kMailboxInitWithReply, 0x00140000), Outcome::kHandled);
  ASSERT_EQ(sink_.replies.size(), 2U);
  EXPECT_EQ(sink_.replies[0].to.client, a);
  EXPECT_EQ(sink_.replies[0].to.handle, 0U);
  EXPECT_EQ(sink_.replies[0].header, (Header{.type = type::kOk, .priority = 7, .seq_nr = 42}));
  EXPECT_EQ(sink_.replies[1].to.client, b);
  EXPECT_EQ(sink_.replies[1].header.type, type::kError);
  EXPECT_EQ(owner(0x00140000), a);
}

// A window of the original's graphical interface beside a log.
TEST_F(RouterTest, AllOwnersOfTheTextSinkGetEachText) {
  const ClientId log = connect(PortKind::kLocal);
  const ClientId sender = connect();
  std::vector<ClientId> windows;
  ASSERT_EQ(router_.register_mailbox(now_, log, kTextSink, 7).status, Registration::Status::kOk);
  EXPECT_FALSE(router_.shares_texts());
  while (windows.size() + 1 < kTextReadersMax) {
    windows.push_back(connect());
    send_command(windows.back(), command::kMailboxInitWithReply, kTextSink.raw());
    EXPECT_EQ(sink_.replies.back().header.type, type::kOk);
  }
  EXPECT_EQ(sink_.moved_addresses, std::vector(kPortKindCount, kTextSink))
      << "every port is notified once";
  for (const ClientId id : {windows.front(), log, connect()}) {
    const Registration again = router_.register_mailbox(now_, id, kTextSink);
    EXPECT_EQ(again.status, Registration::Status::kAddressInUse) << "its own already, or too many";
  }
  const Header text{.type = -126, .dest = kTextSink, .src = Address(0x00140000)};
  EXPECT_EQ(send(sender, text, bytes_of("hello")), Outcome::kDelivered);
  ASSERT_EQ(sink_.delivered.size(), kTextReadersMax);
  std::vector<ClientId> to;
  for (const auto& delivery : sink_.delivered) {
    to.push_back(delivery.to.client);
    EXPECT_EQ(Bytes(delivery.bytes.begin() + kHeaderSize, delivery.bytes.end()), bytes_of("hello"));
    EXPECT_EQ(delivery.to.handle, delivery.to.client == log ? 7U : 0U);
  }
  EXPECT_EQ(to.back(), log) << "the first one answers for what becomes of it";
  to.pop_back();
  EXPECT_EQ(to, windows);
}

TEST_F(RouterTest, WhoeverHasTheSinkOfTextsMayGo) {
  const ClientId first = connect();
  const ClientId second = connect(PortKind::kLocal);
  const ClientId third = connect();
  for (const ClientId id : {first, second, third})
    (void)router_.register_mailbox(now_, id, kTextSink, id == second ? 9 : 0);
  const Header command{.type = 21, .dest = kTextSink, .src = kTextSink};
  EXPECT_EQ(send(second, command), Outcome::kDelivered) << "its own address";
  ASSERT_EQ(sink_.delivered.size(), 1U) << "windows of the original know texts only";
  EXPECT_EQ(sink_.delivered[0].to.client, second);
  EXPECT_EQ(sink_.delivered[0].to.handle, 9U);
  send_command(third, command::kMailboxDeleteWithReply, kTextSink.raw());
  EXPECT_EQ(sink_.replies.back().header.type, type::kOk);
  EXPECT_EQ(owner(kTextSink.raw()), first);
  EXPECT_TRUE(router_.shares_texts());
  router_.disconnect(now_, first, CloseReason::kPeerClosed);
  EXPECT_EQ(owner(kTextSink.raw()), second) << "the next one";
  EXPECT_EQ(router_.find(kTextSink)->handle, 9U);
  EXPECT_FALSE(router_.shares_texts());
  EXPECT_EQ(router_.remove_mailbox(now_, second, kTextSink), Removal::kOk);
  EXPECT_EQ(owner(kTextSink.raw()), kNoClient);
}

TEST_F(RouterTest, ATextThatNobodyReadsIsNoDrop) {
  const ClientId a = connect();
  EXPECT_EQ(send(a, {.type = -126, .dest = kTextSink, .src = Address(1)}), Outcome::kUnread);
  EXPECT_EQ(router_.drops().last_minute(now_), 0U);
  EXPECT_TRUE(sink_.replies.empty());
  EXPECT_EQ(send(a, {.type = 21, .dest = kTextSink, .src = Address(1)}), Outcome::kNoRoute);
}

TEST_F(RouterTest, InitAndDeleteWithoutReplyAreSilent) {
  const ClientId a = connect();
  send_command(a, command::kMailboxInit, 0xFFFFFFFF);
  EXPECT_EQ(owner(0xFFFFFFFF), a);
  send_command(a, command::kMailboxInit, 0xFFFFFFFF);
  send_command(a, command::kMailboxDelete, 0xFFFFFFFF);
  EXPECT_EQ(owner(0xFFFFFFFF), kNoClient);
  EXPECT_TRUE(sink_.replies.empty());
}

TEST_F(RouterTest, TheBodyIsReadInTheOrderOfItsFlag) {
  const ClientId a = connect();
  Bytes body = bytes_of(std::string_view("\x02\x01\x14\x00surplus", 11));
  send(a, {.flags = flag::kBodyLittleEndian, .type = command::kMailboxInit}, body);
  EXPECT_EQ(owner(0x00140102), a);
  send(a, {.flags = flag::kHeaderLittleEndian, .type = command::kMailboxInit}, body);
  EXPECT_EQ(owner(0x02011400), a);
}

TEST_F(RouterTest, DeleteIsForTheOwner) {
  const ClientId a = connect();
  const ClientId b = connect();
  send_command(a, command::kMailboxInit, 1);
  send_command(b, command::kMailboxDelete, 1);
  send_command(b, command::kMailboxDeleteWithReply, 1);
  send_command(b, command::kMailboxDeleteWithReply, 2);
  EXPECT_EQ(owner(1), a);
  send_command(a, command::kMailboxDeleteWithReply, 1);
  EXPECT_EQ(owner(1), kNoClient);
  ASSERT_EQ(sink_.replies.size(), 3U);
  EXPECT_EQ(sink_.replies[0].header.type, type::kError);  // owned by another client
  EXPECT_EQ(sink_.replies[1].header.type, type::kOk);     // not registered
  EXPECT_EQ(sink_.replies[2].header.type, type::kOk);
  EXPECT_EQ(count(EventKind::kDeleteRefused), 2U);
}

TEST_F(RouterTest, CompatDeleteIsForEverybodyButNotForLocalMailboxes) {
  auto settings = router_.settings();
  settings.compat_delete = true;
  router_.configure(now_, settings);
  const ClientId a = connect();
  const ClientId local = connect(PortKind::kLocal);
  send_command(a, command::kMailboxInit, 1);
  router_.register_mailbox(now_, local, Address(2));
  const ClientId b = connect();
  send_command(b, command::kMailboxDeleteWithReply, 1);
  send_command(b, command::kMailboxDeleteWithReply, 2);
  EXPECT_EQ(owner(1), kNoClient);
  EXPECT_EQ(owner(2), local);
  EXPECT_EQ(sink_.replies[0].header.type, type::kOk);
  EXPECT_EQ(sink_.replies[1].header.type, type::kError);
  // The owner stays connected, and may register it again.
  send_command(a, command::kMailboxInit, 1);
  EXPECT_EQ(owner(1), a);
}

TEST_F(RouterTest, PurgeTakesOnlyTheOwnMailboxes) {
  const ClientId a = connect();
  const ClientId b = connect();
  for (std::uint32_t i = 1; i <= 4; ++i) send_command(i % 2 == 0 ? a : b, command::kMailboxInit, i);
  EXPECT_EQ(send(a, {.type = command::kMailboxPurge}), Outcome::kHandled);
  EXPECT_EQ(owner(2), kNoClient);
  EXPECT_EQ(owner(4), kNoClient);
  EXPECT_EQ(owner(1), b);
  EXPECT_EQ(owner(3), b);
}

TEST_F(RouterTest, ShortRegistrationsAreNotAnswered) {
  const ClientId a = connect();
  for (const std::int8_t type : {command::kMailboxInit, command::kMailboxInitWithReply,
                                 command::kMailboxDelete, command::kMailboxDeleteWithReply}) {
    EXPECT_EQ(send(a, {.type = type}), Outcome::kMalformedCommand);
    EXPECT_EQ(send(a, {.type = type}, bytes_of("abc")), Outcome::kMalformedCommand);
  }
  EXPECT_TRUE(sink_.replies.empty());
  EXPECT_EQ(count(PortKind::kTcp, Outcome::kMalformedCommand), 8U);
}

TEST_F(RouterTest, UnknownCommandsAreIgnoredAndCounted) {
  const ClientId a = connect();
  for (const std::int8_t type : {std::int8_t{1}, std::int8_t{16}, command::kLifesign,
                                 std::int8_t{20}, std::int8_t{127}, std::int8_t{-10}}) {
    EXPECT_EQ(send(a, {.type = type}), Outcome::kUnknownCommand);
  }
  EXPECT_EQ(send(a, {.type = command::kLogin}), Outcome::kHandled);
  EXPECT_TRUE(sink_.replies.empty());
}

TEST_F(RouterTest, ALoginIsNotAnsweredWhereAddressesAreAsTheOriginals) {
  const ClientId a = connect();
  EXPECT_EQ(send(a, {.type = command::kLogin}, Bytes(command::kWidthsSize)), Outcome::kHandled);
  EXPECT_TRUE(sink_.replies.empty());
  EXPECT_TRUE(sink_.delivered.empty());
}

TEST(RouterOfOtherWidths, ALoginWithRoomForThemGetsTheWidths) {
  constexpr AddressWidths kWidths{6, 8, 10, 8};
  RecordingSink sink;
  Router router({.address = Address::of({.system = 1}, kWidths), .widths = kWidths}, {1, 2}, sink);
  attach_all(router, sink);
  const Time now(std::chrono::seconds(1));
  const ClientId client = router.connect(now, {.port = PortKind::kTcp, .token = 1});
  const auto login = [&](const Bytes& body) {
    Header header{.flags = 0, .type = command::kLogin, .priority = 3, .seq_nr = 7};
    Bytes bytes = encoded(header, body);
    header.length = static_cast<std::uint32_t>(bytes.size());
    Message message{.header = header, .bytes = bytes};
    EXPECT_EQ(router.on_message(now, client, message), Outcome::kHandled);
  };
  login({});
  login(Bytes(command::kWidthsSize + 1));
  EXPECT_TRUE(sink.delivered.empty());
  login(Bytes(command::kWidthsSize));
  ASSERT_EQ(sink.delivered.size(), 1U);
  const auto& answer = sink.delivered[0];
  EXPECT_EQ(answer.to.client, client);
  EXPECT_EQ(answer.header.type, command::kAddressWidths);
  EXPECT_EQ(answer.header.seq_nr, 7);
  EXPECT_EQ(answer.header.length, kHeaderSize + command::kWidthsSize);
  const auto body = std::span(answer.bytes).subspan(kHeaderSize);
  EXPECT_EQ(command::decode_widths(body), kWidths);
  EXPECT_FALSE(command::decode_widths(body.first(3)));
  EXPECT_FALSE(command::decode_widths(Bytes(command::kWidthsSize))) << "not 32 bits in all";
}

// --- Watchdog

class WatchdogTest : public RouterTest {
 protected:
  ClientId connect_watched() {
    return router_.connect(now_, {.port = PortKind::kTcp, .token = ++token_, .lifesign = true});
  }
  void answer_lifesign(ClientId client) { send(client, {.flags = 0, .type = type::kOk}); }
  // Lets time pass to the next beat; how many lifesigns went out.
  std::size_t beat() {
    now_ = router_.next_timeout();
    sink_.replies.clear();
    router_.on_timeout(now_);
    return sink_.replies.size();
  }
};

TEST_F(WatchdogTest, NoTimerWhileNobodyNeedsOne) {
  EXPECT_EQ(router_.next_timeout(), kNever);
  connect();
  EXPECT_EQ(router_.next_timeout(), kNever);
  const ClientId watched = connect_watched();
  EXPECT_EQ(router_.next_timeout(), now_ + 5s);
  send(watched, {.type = command::kDisableWatchdog});
  EXPECT_EQ(router_.next_timeout(), kNever);
  send(watched, {.type = command::kEnableWatchdog});
  EXPECT_EQ(router_.next_timeout(), now_ + 5s);
  router_.disconnect(now_, watched, CloseReason::kPeerClosed);
  EXPECT_EQ(router_.next_timeout(), kNever);
}

TEST_F(WatchdogTest, OneBeatForAll) {
  connect_watched();
  now_ += 3s;
  connect_watched();
  EXPECT_EQ(router_.next_timeout(), at(105));
  router_.on_timeout(at(104));
  EXPECT_TRUE(sink_.replies.empty());
  EXPECT_EQ(beat(), 2U);
  EXPECT_EQ(router_.next_timeout(), at(110));
  EXPECT_EQ(sink_.replies[0].header, (Header{.type = command::kLifesign}));
}

TEST_F(WatchdogTest, SilentClientsAreClosedAtTheNextBeat) {
  const ClientId silent = connect_watched();
  const ClientId living = connect_watched();
  send_command(silent, command::kMailboxInit, 1);
  EXPECT_EQ(beat(), 2U);
  answer_lifesign(living);
  EXPECT_EQ(beat(), 1U);
  ASSERT_EQ(sink_.closed.size(), 1U);
  EXPECT_EQ(sink_.closed[0].client, silent);
  EXPECT_EQ(sink_.closed[0].reason, CloseReason::kWatchdog);
  EXPECT_EQ(router_.client(silent), nullptr);
  EXPECT_EQ(owner(1), kNoClient);
  EXPECT_EQ(sink_.events.back().kind, EventKind::kWatchdogClosed);
}

TEST_F(WatchdogTest, OnlyOkEnableAndDisableCount) {
  const ClientId ok = connect_watched();
  const ClientId enable = connect_watched();
  const ClientId disable = connect_watched();
  const ClientId traffic = connect_watched();
  beat();
  answer_lifesign(ok);
  send(enable, {.type = command::kEnableWatchdog});
  send(disable, {.type = command::kDisableWatchdog});
  send_command(traffic, command::kMailboxInit, 1);
  send(traffic, {.type = type::kOk, .dest = Address(5), .src = Address(1)});
  send(traffic, {.type = command::kLifesign});
  EXPECT_EQ(beat(), 2U);  // ok and enable
  ASSERT_EQ(sink_.closed.size(), 1U);
  EXPECT_EQ(sink_.closed[0].client, traffic);
}

TEST_F(WatchdogTest, AClientThatStillReadsIsNotClosed) {
  const ClientId slow = connect_watched();
  beat();
  router_.on_progress(slow);
  EXPECT_EQ(beat(), 1U);
  EXPECT_EQ(beat(), 0U);
  EXPECT_EQ(sink_.closed.size(), 1U);
}

TEST_F(WatchdogTest, ARouterThatWasAwayItselfBlamesNobody) {
  connect_watched();
  EXPECT_EQ(beat(), 1U);
  router_.on_timeout(at(200));
  EXPECT_TRUE(sink_.closed.empty());
  EXPECT_EQ(sink_.replies.size(), 2U);
  EXPECT_EQ(router_.next_timeout(), at(205));
  EXPECT_EQ(beat(), 0U);
  EXPECT_EQ(sink_.closed.size(), 1U);
}

TEST_F(WatchdogTest, AShorterIntervalHoldsAtOnce) {
  connect_watched();
  auto settings = router_.settings();
  settings.lifesign_interval = 1s;
  router_.configure(now_, settings);
  EXPECT_EQ(router_.next_timeout(), now_ + 1s);
}

}  // namespace router_commands_test
}  // namespace tims::core::test
