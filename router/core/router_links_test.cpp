// Announcements received over links.
#include <map>
#include <string>

#include <gmock/gmock.h>

#include "router/core/router_fixture.h"
#include "tims/origin.h"

namespace tims::core::test {
namespace router_links_test {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

constexpr Address kLadar(0x01140000);
constexpr Address kPilot(0x00180000);
constexpr Origin kRobot{Address(0x01000100), 5, 1};
constexpr Origin kFar{Address(0x01000200), 6, 2};

class RouterLinksTest : public RouterTest {
 protected:
  [[nodiscard]] std::size_t events(EventKind kind) const {
    return static_cast<std::size_t>(
        std::ranges::count(sink_.events, kind, [](const Event& e) { return e.kind; }));
  }
};

TEST_F(RouterLinksTest, WhatALinkAnnouncesGoesThereAndGoesWithIt) {
  const ClientId sub = link(LinkKind::kSub, 1, "robot1");
  ASSERT_TRUE(router_.learn(now_, sub, kLadar, kRobot));
  EXPECT_EQ(owner(kLadar.raw()), sub);
  EXPECT_EQ(router_.exported(kLadar), kRobot);
  router_.disconnect(now_, sub, CloseReason::kSilent);
  EXPECT_EQ(owner(kLadar.raw()), kNoClient);
  EXPECT_EQ(router_.exported(kLadar), std::nullopt);
  EXPECT_EQ(events(EventKind::kLinkDown), 1U);
}

// A program of another host is no program of this one, whatever that router has sent.
TEST_F(RouterLinksTest, MessagesOfOtherHostsAreMarked) {
  const ClientId sub = link(LinkKind::kSub, 1, "robot1");
  ASSERT_TRUE(router_.learn(now_, sub, kLadar, kRobot));
  router_.register_mailbox(now_, connect(PortKind::kLocal), kPilot);
  send(sub, {.flags = flag::kNativeOrder, .type = 10, .dest = kPilot, .src = kLadar});
  ASSERT_EQ(sink_.delivered.size(), 1U);
  EXPECT_TRUE(is_foreign(sink_.delivered[0].header));
}

TEST_F(RouterLinksTest, RoutersBehindALinkThatGoesAreMissing) {
  const auto missing = [&] {
    std::map<Address, std::string> all;  // and the link they are behind
    router_.missing().for_each(now_, [&](const MissingRouter& m) {
      all[m.router] = std::string(m.via.view()) + (m.behind == m.router ? " itself" : "");
    });
    return all;
  };
  const ClientId sub = link(LinkKind::kSub, 1, "robot1");
  ASSERT_TRUE(router_.learn(now_, sub, kRobot.router, kRobot));
  ASSERT_TRUE(router_.learn(now_, sub, kFar.router, kFar));
  ASSERT_TRUE(router_.learn(now_, sub, kLadar, kFar));
  EXPECT_THAT(missing(), IsEmpty());
  router_.disconnect(now_, sub, CloseReason::kSilent);
  EXPECT_THAT(missing(),
              ElementsAre(Pair(kRobot.router, "robot1 itself"), Pair(kFar.router, "robot1")));
  // Back after a restart.
  const ClientId again = link(LinkKind::kSub, 1, "robot1");
  router_.learn(now_, again, kRobot.router, {kRobot.router, 9, 1});
  EXPECT_THAT(missing(), ElementsAre(Pair(kFar.router, "robot1")));
  router_.learn(now_, again, kFar.router, kFar);
  EXPECT_THAT(missing(), IsEmpty());
}

TEST_F(RouterLinksTest, ARouterThatSaysGoodbyeIsNotMissing) {
  const ClientId sub = link(LinkKind::kSub, 1, "robot1");
  ASSERT_TRUE(router_.learn(now_, sub, kRobot.router, kRobot));
  ASSERT_TRUE(router_.learn(now_, sub, kFar.router, kFar));
  router_.disconnect(now_, sub, CloseReason::kShutdown);
  std::vector<Address> missing;
  router_.missing().for_each(now_, [&](const MissingRouter& m) { missing.push_back(m.router); });
  EXPECT_THAT(missing, ElementsAre(kFar.router)) << "routers behind it sent no CLOSE";
}

TEST_F(RouterLinksTest, ARouterThatAnotherLinkBringsIsNotMissing) {
  const ClientId one = link(LinkKind::kSub, 1, "robot1");
  const ClientId other = link(LinkKind::kSub, 1, "spare");
  ASSERT_TRUE(router_.learn(now_, one, kFar.router, kFar));
  ASSERT_TRUE(router_.learn(now_, other, kFar.router, kFar));
  int missing = 0;
  router_.disconnect(now_, one, CloseReason::kSilent);
  router_.missing().for_each(now_, [&](const MissingRouter&) { ++missing; });
  EXPECT_EQ(missing, 0);
  // A router withdrawn while its link is up is not missing: the neighbour reported the withdrawal.
  router_.forget(now_, other, kFar.router);
  router_.missing().for_each(now_, [&](const MissingRouter&) { ++missing; });
  EXPECT_EQ(missing, 0);
}

TEST_F(RouterLinksTest, LinksTakeNoPlaceOfClients) {
  std::vector<ClientId> links;
  links.reserve(200);
  for (int i = 0; i < 200; ++i) links.push_back(link(LinkKind::kSub, 1, "robot"));
  for (std::uint32_t i = 0; i < router_.settings().clients_max; ++i)
    EXPECT_TRUE(connect(PortKind::kLocal));
  EXPECT_FALSE(connect(PortKind::kLocal));
  for (const ClientId id : links) router_.disconnect(now_, id, CloseReason::kSilent);
  EXPECT_FALSE(connect(PortKind::kLocal));
}

TEST_F(RouterLinksTest, NobodyHereDeletesWhatIsBehindALink) {
  auto settings = router_.settings();
  settings.compat_delete = true;
  router_.configure(now_, settings);
  const ClientId sub = link(LinkKind::kSub, 1, "robot1");
  router_.learn(now_, sub, kLadar, kRobot);
  send_command(connect(), command::kMailboxDeleteWithReply, kLadar.raw());
  EXPECT_EQ(owner(kLadar.raw()), sub);
  ASSERT_EQ(sink_.replies.size(), 1U);
  EXPECT_EQ(sink_.replies[0].header.type, type::kError);
}

TEST_F(RouterLinksTest, RoutesFromAboveOrBesideAreNotExported) {
  const ClientId peer = link(LinkKind::kPeer, 2, "robot2");
  ASSERT_TRUE(router_.learn(now_, peer, kLadar, kRobot));
  EXPECT_EQ(owner(kLadar.raw()), peer);
  EXPECT_EQ(router_.exported(kLadar), std::nullopt);
  EXPECT_EQ(router_.exported_table().size(), 1U) << "the router itself";
}

// Every robot has its own, at the same address.
TEST_F(RouterLinksTest, TheSinkOfTextsIsEachRoutersOwn) {
  const ClientId up = link(LinkKind::kSuper, 0, "base");
  router_.set_uplink(now_, up);
  const ClientId sub = link(LinkKind::kSub, 1, "robot1");
  EXPECT_FALSE(router_.learn(now_, sub, text_sink(), kRobot));
  EXPECT_EQ(hop_of(sub, text_sink()), up) << "nobody here reads texts";
  const std::uint32_t hash = router_.exported_table().hash();
  const ClientId log = connect();
  send_command(log, command::kMailboxInitWithReply, text_sink().raw());
  EXPECT_EQ(hop_of(sub, text_sink()), log);
  EXPECT_EQ(router_.exported(text_sink()), std::nullopt);
  EXPECT_EQ(router_.exported_table().hash(), hash);
  EXPECT_FALSE(router_.learn(now_, sub, text_sink(), kRobot));
  router_.disconnect(now_, log, CloseReason::kPeerClosed);
  EXPECT_EQ(router_.exported_table().hash(), hash);
  EXPECT_EQ(events(EventKind::kDuplicateAddress), 0U);
}

TEST_F(RouterLinksTest, NobodyElseHasOurAddress) {
  const ClientId sub = link(LinkKind::kSub, 1, "robot1");
  router_.learn(now_, sub, kOwn, kRobot);
  EXPECT_EQ(owner(kOwn.raw()), kNoClient);
  EXPECT_EQ(router_.exported(kOwn)->router, kOwn);
  EXPECT_EQ(events(EventKind::kDuplicateAddress), 1U);
}

TEST_F(RouterLinksTest, ALinkCommandsNothing) {
  const ClientId sub = link(LinkKind::kSub, 1, "robot1");
  EXPECT_EQ(send_command(sub, command::kMailboxInitWithReply, kLadar.raw()),
            Outcome::kMalformedCommand);
  EXPECT_EQ(router_.register_mailbox(now_, sub, kLadar, 7).status,
            Registration::Status::kNoSuchClient);
  EXPECT_EQ(owner(kLadar.raw()), kNoClient);
  EXPECT_TRUE(sink_.replies.empty());
}

TEST_F(RouterLinksTest, TheSecondOwnerWaitsAndBothAreNamed) {
  const ClientId first = link(LinkKind::kSub, 1, "robot1");
  const ClientId second = link(LinkKind::kSub, 2, "robot2");
  router_.learn(now_, first, kLadar, kRobot);
  router_.learn(now_, second, kLadar, kFar);
  EXPECT_EQ(owner(kLadar.raw()), first);
  ASSERT_EQ(events(EventKind::kDuplicateAddress), 1U);
  const Event& event = sink_.events.back();
  EXPECT_EQ(event.client.name.view(), "robot2");
  EXPECT_EQ(event.owner.name.view(), "robot1");
  router_.forget(now_, first, kLadar);
  EXPECT_EQ(owner(kLadar.raw()), second) << "it has waited";
}

TEST_F(RouterLinksTest, TheShorterOfTwoRoutesToARouterIsTaken) {
  const ClientId longer = link(LinkKind::kSub, 1, "long");
  const ClientId shorter = link(LinkKind::kSub, 2, "short");
  router_.learn(now_, longer, kLadar, {kRobot.router, kRobot.epoch, 3});
  router_.learn(now_, shorter, kLadar, {kRobot.router, kRobot.epoch, 2});
  EXPECT_EQ(owner(kLadar.raw()), shorter);
  EXPECT_EQ(events(EventKind::kDuplicateAddress), 0U);
  router_.learn(now_, link(LinkKind::kSub, 3, "detour"), kLadar, {kRobot.router, kRobot.epoch, 4});
  EXPECT_EQ(owner(kLadar.raw()), shorter);
  router_.disconnect(now_, shorter, CloseReason::kSilent);
  EXPECT_EQ(owner(kLadar.raw()), longer);
}

TEST_F(RouterLinksTest, ARouterThatWasRestartedIsNoDuplicateOfItself) {
  const ClientId before = link(LinkKind::kSub, 1, "before");
  const ClientId after = link(LinkKind::kSub, 1, "after");
  router_.learn(now_, before, kLadar, kRobot);
  router_.learn(now_, after, kLadar, {kRobot.router, kRobot.epoch + 1, kRobot.hops});
  EXPECT_EQ(events(EventKind::kDuplicateAddress), 0U);
  router_.disconnect(now_, before, CloseReason::kSilent);
  EXPECT_EQ(owner(kLadar.raw()), after);
}

TEST_F(RouterLinksTest, ALinkThatIsGoneWaitsForNothing) {
  const ClientId first = link(LinkKind::kSub, 1, "robot1");
  const ClientId second = link(LinkKind::kSub, 2, "robot2");
  router_.learn(now_, first, kLadar, kRobot);
  router_.learn(now_, second, kLadar, kFar);
  router_.disconnect(now_, second, CloseReason::kSilent);
  EXPECT_EQ(router_.announced(second, kLadar), std::nullopt);
}

TEST_F(RouterLinksTest, OurOwnMailboxesComingBackAreALoop) {
  const ClientId sub = link(LinkKind::kSub, 1, "robot1");
  EXPECT_FALSE(router_.learn(now_, sub, kLadar, {kOwn, router_.settings().epoch, 3}));
  EXPECT_FALSE(router_.learn(now_, sub, kLadar, {kRobot.router, 5, kHopsMax}));
  EXPECT_EQ(events(EventKind::kLoop), 2U);
  EXPECT_FALSE(router_.learn(now_, sub, kLadar, {kOwn, router_.settings().epoch + 1, 3}));
  EXPECT_EQ(events(EventKind::kDuplicateRouter), 1U) << "somebody else with our address";
  EXPECT_EQ(owner(kLadar.raw()), kNoClient);
}

TEST_F(RouterLinksTest, TheHopLimitEndsALoopAndNamesTheRouters) {
  const ClientId from = link(LinkKind::kSub, 1, "robot1");
  const ClientId to = link(LinkKind::kSub, 2, "robot2");
  router_.learn(now_, to, kLadar, kRobot);
  for (const std::uint8_t hops : {std::uint8_t{kHopsMax - 1}, kHopsMax}) {
    Bytes bytes = encoded({.type = 3, .dest = kLadar, .src = Address(0x01180000)});
    Message message{wire::decode_header(std::span(bytes).first<kHeaderSize>()), bytes, hops};
    EXPECT_EQ(router_.on_message(now_, from, message),
              hops < kHopsMax ? Outcome::kDelivered : Outcome::kHopLimit);
  }
  ASSERT_EQ(events(EventKind::kLoop), 1U);
  EXPECT_EQ(sink_.events.back().client.name.view(), "robot1");
  EXPECT_EQ(sink_.events.back().owner.name.view(), "robot2");
}

TEST_F(RouterLinksTest, ACommandThatALinkHasLostIsAnswered) {
  const ClientId sub = link(LinkKind::kSub, 1, "robot1");
  const ClientId local = connect();
  router_.register_mailbox(now_, local, kPilot, 9);
  router_.on_undelivered(now_, sub, {.type = 3, .seq_nr = 4, .dest = kLadar, .src = kPilot},
                         Outcome::kExpired);
  router_.on_undelivered(now_, sub, {.type = -6, .dest = kLadar, .src = kPilot}, Outcome::kExpired);
  ASSERT_EQ(sink_.replies.size(), 1U) << "data is not answered";
  EXPECT_EQ(sink_.replies[0].to.handle, 9U);
  EXPECT_EQ(sink_.replies[0].header.seq_nr, 4);
  EXPECT_EQ(count(PortKind::kLink, Outcome::kExpired), 2U);
}

}  // namespace router_links_test
}  // namespace tims::core::test
