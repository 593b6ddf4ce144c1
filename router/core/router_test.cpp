#include "router/core/router.h"

#include "router/core/router_fixture.h"
#include "tims/origin.h"

namespace tims::core::test {
namespace router_test {

constexpr Address kLaser{0x00140000};
constexpr Address kPilot{0x00180000};

// --- Clients and mailboxes

TEST_F(RouterTest, ARegisteredMailboxIsFoundUntilItsClientGoes) {
  const ClientId laser = connect();
  EXPECT_EQ(router_.register_mailbox(now_, laser, kLaser, 42).status, Registration::Status::kOk);
  ASSERT_NE(router_.find(kLaser), nullptr);
  EXPECT_EQ(router_.find(kLaser)->owner, laser);
  EXPECT_EQ(router_.find(kLaser)->handle, 42U);
  router_.disconnect(now_, laser, CloseReason::kPeerClosed);
  EXPECT_EQ(router_.find(kLaser), nullptr);
  EXPECT_EQ(router_.client(laser), nullptr);
}

TEST_F(RouterTest, AnAddressHasOneOwnerAndTheRefusalNamesBoth) {
  const ClientId first = connect(PortKind::kLocal, "laser");
  const ClientId second = connect(PortKind::kTcp, "other");
  router_.register_mailbox(now_, first, kLaser);
  const Registration refused = router_.register_mailbox(now_, second, kLaser);
  EXPECT_EQ(refused.status, Registration::Status::kAddressInUse);
  EXPECT_EQ(refused.owner, first);
  EXPECT_EQ(owner(0x00140000), first);
  const Event& event = sink_.events.back();
  EXPECT_EQ(event.kind, EventKind::kAddressRefused);
  EXPECT_EQ(event.client.name.view(), "other");
  EXPECT_EQ(event.owner.name.view(), "laser");
  EXPECT_EQ(event.address, kLaser);
}

TEST_F(RouterTest, TheSameClientMayNotRegisterTwiceEither) {
  const ClientId laser = connect();
  router_.register_mailbox(now_, laser, kLaser);
  EXPECT_EQ(router_.register_mailbox(now_, laser, kLaser).status,
            Registration::Status::kAddressInUse);
}

TEST_F(RouterTest, TheRoutersOwnAddressIsTaken) {
  const Registration refused = router_.register_mailbox(now_, connect(), kOwn);
  EXPECT_EQ(refused.status, Registration::Status::kAddressInUse);
  EXPECT_EQ(refused.owner, kNoClient);
}

// Room for 100 clients.
TEST_F(RouterTest, GuestsOfOnePortDoNotShutOutOthers) {
  const auto connect_all = [&](PortKind port) {
    int count = 0;
    while (router_.has_room(port) && connect(port)) ++count;
    EXPECT_FALSE(connect(port));
    return count;
  };
  EXPECT_EQ(connect_all(PortKind::kWebSocket), 25);
  EXPECT_EQ(connect_all(PortKind::kTcp), 50);
  EXPECT_EQ(connect_all(PortKind::kLocal), 25);
  EXPECT_TRUE(router_.has_room(PortKind::kLink));
  EXPECT_EQ(router_.clients().size(PortKind::kTcp), 50U);
}

TEST_F(RouterTest, ProgramsOfThisHostMayHaveAllPlaces) {
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(connect(PortKind::kLocal));
  EXPECT_FALSE(connect(PortKind::kTcp));
  EXPECT_FALSE(connect(PortKind::kWebSocket));
}

TEST_F(RouterTest, OneClientMayBeABrowser) {
  auto settings = router_.settings();
  settings.clients_max = 1;
  router_.configure(now_, settings);
  EXPECT_TRUE(connect(PortKind::kWebSocket));
  EXPECT_FALSE(connect(PortKind::kWebSocket));
}

TEST_F(RouterTest, ClientsAndMailboxesAreLimited) {
  const ClientId laser = connect(PortKind::kLocal);
  for (std::uint32_t i = 0; i < 10; ++i) router_.register_mailbox(now_, laser, Address(i));
  EXPECT_EQ(router_.register_mailbox(now_, laser, kLaser).status, Registration::Status::kTooMany);
  EXPECT_EQ(sink_.events.back().kind, EventKind::kMailboxLimit);
  for (int i = 1; i < 100; ++i) EXPECT_TRUE(connect(PortKind::kLocal));
  EXPECT_FALSE(connect(PortKind::kLocal));
  EXPECT_EQ(count(EventKind::kClientRefused), 1U);
  router_.disconnect(now_, laser, CloseReason::kPeerClosed);
  EXPECT_TRUE(connect(PortKind::kLocal));
}

TEST_F(RouterTest, OnlyTheOwnerRemovesAMailbox) {
  const ClientId laser = connect();
  const ClientId other = connect();
  router_.register_mailbox(now_, laser, kLaser);
  EXPECT_EQ(router_.remove_mailbox(now_, other, kLaser), Removal::kNotOwner);
  EXPECT_EQ(sink_.events.back().kind, EventKind::kDeleteRefused);
  EXPECT_EQ(owner(0x00140000), laser);
  EXPECT_EQ(router_.remove_mailbox(now_, laser, kLaser), Removal::kOk);
  EXPECT_EQ(router_.remove_mailbox(now_, laser, kLaser), Removal::kUnknown);
}

TEST_F(RouterTest, RemovingOneMailboxLeavesTheOthersOfItsClient) {
  const ClientId laser = connect();
  for (std::uint32_t i = 1; i <= 5; ++i) router_.register_mailbox(now_, laser, Address(i), i);
  router_.remove_mailbox(now_, laser, Address(2));
  router_.remove_mailbox(now_, laser, Address(5));
  router_.remove_mailbox(now_, laser, Address(1));
  for (const std::uint32_t i : {3U, 4U}) {
    ASSERT_NE(router_.find(Address(i)), nullptr);
    EXPECT_EQ(router_.find(Address(i))->handle, i);
  }
  for (const std::uint32_t i : {3U, 4U}) router_.remove_mailbox(now_, laser, Address(i));
  EXPECT_EQ(router_.table().size(), 0U);
  EXPECT_NE(router_.client(laser), nullptr);
}

// --- Forwarding

TEST_F(RouterTest, ForwardsToTheOwnerInTheMachinesOwnOrder) {
  const ClientId laser = connect();
  const ClientId pilot = connect();
  router_.register_mailbox(now_, laser, kLaser);
  router_.register_mailbox(now_, pilot, kPilot);
  const Header big_endian{.flags = 0xC0, .type = 8, .priority = 3, .dest = kLaser, .src = kPilot};
  EXPECT_EQ(send(pilot, big_endian, bytes_of("body")), Outcome::kDelivered);
  ASSERT_EQ(sink_.delivered.size(), 1U);
  const auto& [to, header, bytes] = sink_.delivered[0];
  EXPECT_EQ(to.client, laser);
  EXPECT_EQ(to.token, 1U);
  // Every flag bit but bit 0 is the sender's.
  const std::uint8_t flags = 0xC0 | (flag::kNativeOrder & flag::kHeaderLittleEndian);
  EXPECT_EQ(bytes,
            encoded({.flags = flags, .type = 8, .priority = 3, .dest = kLaser, .src = kPilot},
                    bytes_of("body")));
  EXPECT_EQ(header.flags, flags);
  EXPECT_EQ(router_.messages().of(PortKind::kTcp, 2, Outcome::kDelivered), (Count{1, 20}));
  EXPECT_EQ(router_.client(pilot)->in, (Count{1, 20}));
  EXPECT_EQ(router_.client(laser)->out, (Count{1, 20}));
}

TEST_F(RouterTest, AnUnknownDestinationOfACommandIsAnswered) {
  const ClientId pilot = connect();
  router_.register_mailbox(now_, pilot, kPilot, 7);
  const Header request{
      .flags = 0, .type = 17, .priority = 200, .seq_nr = 9, .dest = kLaser, .src = kPilot};
  EXPECT_EQ(send(pilot, request), Outcome::kNoRoute);
  ASSERT_EQ(sink_.replies.size(), 1U);
  EXPECT_EQ(sink_.replies[0].to.client, pilot);
  EXPECT_EQ(sink_.replies[0].to.handle, 7U);
  EXPECT_EQ(sink_.replies[0].header, (Header{.type = type::kNotAvailable,
                                             .priority = 200,
                                             .seq_nr = 9,
                                             .dest = kPilot,
                                             .src = kLaser}));
  EXPECT_EQ(router_.messages().of(PortKind::kTcp, 7, Outcome::kNoRoute), (Count{1, 16}));
}

TEST_F(RouterTest, AnUnknownDestinationOfAReplyIsSilent) {
  const ClientId pilot = connect();
  for (const std::int8_t type : {std::int8_t{0}, std::int8_t{-1}, std::int8_t{-128}}) {
    EXPECT_EQ(send(pilot, {.type = type, .dest = kLaser, .src = kPilot}), Outcome::kNoRoute);
  }
  EXPECT_TRUE(sink_.replies.empty());
  EXPECT_EQ(count(PortKind::kTcp, Outcome::kNoRoute), 3U);
}

TEST_F(RouterTest, Address0IsAnAddressForMessagesWithASource) {
  const ClientId laser = connect();
  router_.register_mailbox(now_, laser, Address(0));
  EXPECT_EQ(send(connect(), {.type = 1, .src = kPilot}), Outcome::kDelivered);
  EXPECT_EQ(sink_.delivered[0].to.client, laser);
}

TEST_F(RouterTest, AMessageToItselfIsDelivered) {
  const ClientId laser = connect();
  router_.register_mailbox(now_, laser, kLaser);
  send(laser, {.type = -1, .dest = kLaser, .src = kLaser});
  ASSERT_EQ(sink_.delivered.size(), 1U);
  EXPECT_EQ(sink_.delivered[0].to.client, laser);
}

TEST_F(RouterTest, AForgedSourceIsToleratedOverTcpAndCounted) {
  const ClientId laser = connect();
  router_.register_mailbox(now_, laser, kLaser);
  EXPECT_EQ(send(connect(), {.type = 1, .dest = kLaser, .src = kPilot}), Outcome::kDelivered);
  EXPECT_EQ(send(connect(PortKind::kWebSocket), {.type = 1, .dest = kLaser, .src = kLaser}),
            Outcome::kDelivered);
  EXPECT_EQ(count(EventKind::kForgedSourceTolerated), 2U);
}

TEST_F(RouterTest, AForgedSourceOfALocalProgramIsDropped) {
  const ClientId laser = connect();
  const ClientId local = connect(PortKind::kLocal);
  router_.register_mailbox(now_, laser, kLaser);
  router_.register_mailbox(now_, local, kPilot);
  EXPECT_EQ(send(local, {.type = 1, .dest = kLaser, .src = kLaser}), Outcome::kForgedSource);
  EXPECT_EQ(send(local, {.type = 1, .dest = kLaser, .src = Address(99)}), Outcome::kForgedSource);
  // dest = src = 0 belongs to the original protocol; local programs use control records.
  EXPECT_EQ(send_command(local, command::kMailboxInit, 5), Outcome::kForgedSource);
  EXPECT_TRUE(sink_.delivered.empty());
  EXPECT_TRUE(sink_.replies.empty());
  EXPECT_EQ(send(local, {.type = 1, .dest = kLaser, .src = kPilot}), Outcome::kDelivered);
}

TEST_F(RouterTest, OurOwnFlagsDoNotReachTcpClientsFromLocalPrograms) {
  const ClientId tcp = connect();
  const ClientId local = connect(PortKind::kLocal);
  const ClientId web = connect(PortKind::kWebSocket);
  router_.register_mailbox(now_, tcp, kLaser);
  router_.register_mailbox(now_, local, kPilot);
  router_.register_mailbox(now_, web, Address(5));
  const std::uint8_t flags =
      flag::kNativeOrder | flag::kStream | flag::kTrace | flag::kReportIfGone | flag::kReportReason;
  send(local, {.flags = flags, .dest = kLaser, .src = kPilot});
  send(local, {.flags = flags, .dest = Address(5), .src = kPilot});
  send(tcp, {.flags = flags, .dest = kLaser, .src = kLaser});
  ASSERT_EQ(sink_.delivered.size(), 3U);
  EXPECT_EQ(sink_.delivered[0].header.flags, flag::kNativeOrder);
  EXPECT_EQ(sink_.delivered[1].header.flags, flags);
  EXPECT_EQ(sink_.delivered[2].header.flags, flags);
}

// The mark is set for messages to this host only, and not taken from the sender.
TEST_F(RouterTest, MessagesToThisHostShowWhetherTheyComeFromIt) {
  const ClientId here = connect(PortKind::kLocal);
  router_.register_mailbox(now_, here, kPilot);
  const auto arrives = [&](PortKind port, std::uint8_t flags) {
    const ClientId sender = connect(port);
    router_.register_mailbox(now_, sender, kLaser);
    send(sender, {.flags = flags, .type = 10, .dest = kPilot, .src = kLaser});
    router_.disconnect(now_, sender, CloseReason::kPeerClosed);
    const auto& last = sink_.delivered.back();
    EXPECT_EQ(Bytes(last.bytes.begin(), last.bytes.begin() + 1).front(),
              static_cast<std::byte>(last.header.flags));
    return is_foreign(last.header);
  };
  const std::uint8_t claims = flag::kNativeOrder | flag::kForeign;
  for (const std::uint8_t flags : {flag::kNativeOrder, claims}) {
    EXPECT_TRUE(arrives(PortKind::kTcp, flags));
    EXPECT_TRUE(arrives(PortKind::kWebSocket, flags));
    EXPECT_FALSE(arrives(PortKind::kLocal, flags));
  }
}

TEST_F(RouterTest, AProducerThatAsksLearnsThatItsListenerIsGone) {
  const ClientId tcp = connect();
  const ClientId local = connect(PortKind::kLocal);
  router_.register_mailbox(now_, tcp, kLaser);
  router_.register_mailbox(now_, local, kPilot);
  const std::uint8_t asks = flag::kNativeOrder | flag::kReportIfGone;
  send(local,
       {.flags = flag::kNativeOrder, .type = type::kData, .dest = Address(5), .src = kPilot});
  EXPECT_TRUE(sink_.replies.empty());
  send(local, {.flags = asks, .type = type::kData, .dest = kLaser, .src = kPilot});
  EXPECT_TRUE(sink_.replies.empty()) << "it is there";
  send(tcp, {.flags = asks, .type = type::kData, .dest = Address(5), .src = kLaser});
  EXPECT_TRUE(sink_.replies.empty()) << "original programs set flags as they like";
  send(local, {.flags = asks, .type = type::kData, .dest = Address(5), .src = kPilot});
  ASSERT_EQ(sink_.replies.size(), 1U);
  EXPECT_EQ(sink_.replies[0].header.type, type::kNotAvailable);
  EXPECT_EQ(sink_.replies[0].header.src, Address(5));
  EXPECT_EQ(sink_.replies[0].header.dest, kPilot);
}

// Between a program of this host and one over TCP, in both directions.
TEST_F(RouterTest, ExtensionFlagsPassToAndFromTcpClientsThatKnowThem) {
  const ClientId tcp = connect();
  const ClientId local = connect(PortKind::kLocal);
  router_.register_mailbox(now_, tcp, kLaser);
  router_.register_mailbox(now_, local, kPilot);
  const std::uint8_t flags = flag::kNativeOrder | flag::kStream;
  const auto passes = [&](ClientId from, Address src, Address dest) {
    send(from, {.flags = flags, .type = type::kData, .dest = dest, .src = src});
    return (sink_.delivered.back().header.flags & flag::kStream) != 0;
  };
  EXPECT_FALSE(passes(tcp, kLaser, kPilot)) << "it may be an original program";
  EXPECT_FALSE(passes(local, kPilot, kLaser));
  const Bytes keeps_newest{std::byte{0x01}, std::byte{0x16}, {}, {}, {}, {}, {}, std::byte{1}};
  send(tcp, {.flags = 0, .type = command::kMailboxInit}, keeps_newest);
  EXPECT_TRUE(passes(tcp, kLaser, kPilot));
  EXPECT_TRUE(passes(local, kPilot, kLaser));
}

TEST_F(RouterTest, OnlyOurOwnProgramsAreTraced) {
  const ClientId tcp = connect();
  const ClientId local = connect(PortKind::kLocal);
  router_.register_mailbox(now_, tcp, kLaser);
  router_.register_mailbox(now_, local, kPilot);
  const std::uint8_t flags = flag::kNativeOrder | flag::kTrace;
  send(tcp, {.flags = flags, .dest = kPilot, .src = kLaser});
  EXPECT_TRUE(sink_.traces.empty());
  send(local, {.flags = flags, .dest = kLaser, .src = kPilot});
  ASSERT_EQ(sink_.traces.size(), 1U);
  EXPECT_EQ(sink_.traces[0], std::pair(local, tcp));
}

// --- What is lost

TEST_F(RouterTest, WhatThePortSaysIsCounted) {
  const ClientId laser = connect();
  router_.register_mailbox(now_, laser, kLaser);
  sink_.outcome = Outcome::kQueueFull;
  EXPECT_EQ(send(laser, {.type = 1, .priority = 255, .dest = kLaser, .src = kLaser}),
            Outcome::kQueueFull);
  EXPECT_EQ(router_.messages().of(PortKind::kTcp, 7, Outcome::kQueueFull), (Count{1, 16}));
  EXPECT_EQ(router_.client(laser)->dropped, (Count{1, 16}));
  EXPECT_EQ(router_.client(laser)->out, Count{});
  EXPECT_EQ(router_.drops().last_minute(now_), 1U);
}

TEST_F(RouterTest, AReplacedMessageIsCountedBesideTheOneThatWasTaken) {
  const ClientId laser = connect(PortKind::kLocal);
  router_.register_mailbox(now_, laser, kLaser);
  sink_.outcome = Outcome::kMailboxReplaced;
  send(connect(), {.type = 1, .dest = kLaser, .src = kPilot});
  EXPECT_EQ(router_.messages().of(PortKind::kTcp, 1, Outcome::kDelivered), (Count{1, 16}));
  EXPECT_EQ(router_.messages().of(PortKind::kLocal, 1, Outcome::kMailboxReplaced), (Count{1, 0}));
  EXPECT_EQ(router_.client(laser)->out.messages, 1U);
  EXPECT_EQ(router_.client(laser)->dropped.messages, 1U);
  EXPECT_EQ(router_.drops().last_minute(now_), 1U);
}

TEST_F(RouterTest, LossesOfAPortAreCountedAlsoAfterTheClientHasGone) {
  const ClientId laser = connect();
  LossCounts losses{};
  losses[0] = {2, 300};
  losses[7] = {1, 50};
  router_.on_lost(now_, PortKind::kTcp, laser, Outcome::kQueueReplaced, losses);
  EXPECT_EQ(router_.client(laser)->dropped, (Count{3, 350}));
  router_.disconnect(now_, laser, CloseReason::kPeerClosed);
  router_.on_lost(now_, PortKind::kTcp, laser, Outcome::kClientGone, losses);
  EXPECT_EQ(router_.messages().total(Outcome::kClientGone), (Count{3, 350}));
  EXPECT_EQ(router_.drops().last_minute(now_), 6U);
}

TEST_F(RouterTest, AClientThatHasGoneCannotSend) {
  const ClientId laser = connect();
  router_.disconnect(now_, laser, CloseReason::kPeerClosed);
  router_.disconnect(now_, laser, CloseReason::kPeerClosed);
  EXPECT_EQ(send(laser, {.type = 1, .dest = kLaser}), Outcome::kClientGone);
  EXPECT_EQ(router_.register_mailbox(now_, laser, kLaser).status,
            Registration::Status::kNoSuchClient);
}

// --- Questions to the router

TEST_F(RouterTest, AQuestionComesFromSocketsAndMailboxes) {
  const ClientId tcp = connect();
  const ClientId local = connect(PortKind::kLocal);
  router_.register_mailbox(now_, local, kPilot);
  EXPECT_EQ(send(tcp, {.type = type::kAdminRequest}), Outcome::kHandled);
  EXPECT_EQ(send(local, {.type = type::kAdminRequest, .dest = kOwn, .src = kPilot}),
            Outcome::kHandled);
  ASSERT_EQ(sink_.questions.size(), 2U);
  EXPECT_EQ(sink_.questions[0], std::pair(tcp, Address(0)));
  EXPECT_EQ(sink_.questions[1], std::pair(local, kPilot));
}

TEST_F(RouterTest, AnAnswerGoesToTheMailboxOrToTheConnection) {
  const ClientId tcp = connect();
  const ClientId local = connect(PortKind::kLocal);
  router_.register_mailbox(now_, local, kPilot, 8);
  Bytes bytes = encoded({.type = type::kAdminReply, .dest = kPilot, .src = kOwn}, bytes_of("{}"));
  Message to_mailbox{wire::decode_header(std::span(bytes).first<kHeaderSize>()), bytes};
  EXPECT_EQ(router_.answer(now_, tcp, to_mailbox), Outcome::kDelivered);
  EXPECT_EQ(sink_.delivered[0].to.handle, 8U);
  bytes = encoded({.type = type::kAdminReply}, bytes_of("{}"));
  Message to_connection{wire::decode_header(std::span(bytes).first<kHeaderSize>()), bytes};
  EXPECT_EQ(router_.answer(now_, tcp, to_connection), Outcome::kDelivered);
  EXPECT_EQ(sink_.delivered[1].to.client, tcp);
  EXPECT_EQ(count(PortKind::kRouter, Outcome::kDelivered), 2U);
  router_.disconnect(now_, tcp, CloseReason::kPeerClosed);
  EXPECT_EQ(router_.answer(now_, tcp, to_connection), Outcome::kClientGone);
}

TEST_F(RouterTest, OtherCommandsToItsAddressAreAnsweredWithAnError) {
  const ClientId tcp = connect();
  router_.register_mailbox(now_, tcp, kPilot);
  EXPECT_EQ(send(tcp, {.type = 3, .seq_nr = 5, .dest = kOwn, .src = kPilot}),
            Outcome::kUnknownCommand);
  ASSERT_EQ(sink_.replies.size(), 1U);
  EXPECT_EQ(sink_.replies[0].header,
            (Header{.type = type::kError, .seq_nr = 5, .dest = kPilot, .src = kOwn}));
  EXPECT_EQ(send(tcp, {.type = -6, .dest = kOwn, .src = kPilot}), Outcome::kUnknownCommand);
  EXPECT_EQ(sink_.replies.size(), 1U);
}

// --- Events

TEST_F(RouterTest, ConnectingAndDisconnectingAreEvents) {
  const ClientId laser = connect(PortKind::kLocal, "laser");
  router_.register_mailbox(now_, laser, kLaser);
  router_.disconnect(at(120), laser, CloseReason::kConnectionLost);
  std::vector<EventKind> kinds;
  kinds.reserve(sink_.events.size());
  for (const Event& event : sink_.events) kinds.push_back(event.kind);
  EXPECT_EQ(kinds, (std::vector{EventKind::kClientCame, EventKind::kRegistered,
                                EventKind::kWithdrawn, EventKind::kClientWent}));
  EXPECT_EQ(sink_.events[2].owner.name.view(), "laser");
  EXPECT_EQ(sink_.events[3].reason, CloseReason::kConnectionLost);
  EXPECT_EQ(sink_.events[3].at, at(120));
  EXPECT_EQ(router_.events().last(), 4U);
}

TEST_F(RouterTest, AProtocolErrorIsAnEventOfItsOwn) {
  router_.disconnect(now_, connect(), CloseReason::kTooLong);
  EXPECT_EQ(sink_.events.back().kind, EventKind::kProtocolError);
  EXPECT_EQ(sink_.events.back().reason, CloseReason::kTooLong);
}

}  // namespace router_test
}  // namespace tims::core::test
