#include "router/core/routes.h"

#include <string_view>

#include <gtest/gtest.h>

#include "router/core/router_fixture.h"
#include "tims/origin.h"

namespace tims::core::test {
namespace routes_test {

constexpr Address kLadar(0x01140000);
constexpr Address kPilot(0x00180000);
constexpr Origin kRobot{Address(0x01000100), 5, 1};
constexpr Origin kFar{Address(0x01000200), 6, 2};

using RoutesTest = RouterTest;

TEST_F(RoutesTest, WhatIsNotKnownGoesUpAndNeverBack) {
  const ClientId up = link(LinkKind::kSuper, 0, "base");
  const ClientId local = connect();
  EXPECT_EQ(hop_of(local, kLadar), kNoClient);
  router_.set_uplink(now_, up);
  EXPECT_EQ(hop_of(local, kLadar), up);
  EXPECT_EQ(hop_of(up, kLadar), kNoClient);
  EXPECT_EQ(send(up, {.type = 3, .dest = kLadar, .src = kPilot}), Outcome::kNoRoute);
  ASSERT_EQ(sink_.replies.size(), 1U);
  EXPECT_EQ(sink_.replies[0].to.client, up);
  EXPECT_EQ(sink_.replies[0].header.type, type::kNotAvailable);
  router_.disconnect(now_, up, CloseReason::kSilent);
  EXPECT_EQ(router_.routes().uplink(), kNoClient);
}

// An operator's joystick for robot 1 may be registered at the base.
TEST_F(RoutesTest, WhatASystemRouterDoesNotKnowOfItsOwnSystemGoesUpToo) {
  Router robot({.address = Address(0x01000100), .role = Role::kSystem}, {1, 2}, sink_);
  const ClientId up =
      robot.connect(now_, {.port = PortKind::kLink, .link = {.kind = LinkKind::kSuper}});
  robot.set_uplink(now_, up);
  EXPECT_EQ(robot.routes().next_hop(nullptr, Address(0x02140000)).to->id, up);
  EXPECT_EQ(robot.routes().next_hop(nullptr, kPilot).to->id, up);
  EXPECT_EQ(robot.routes().next_hop(nullptr, kLadar).to->id, up);
  EXPECT_EQ(robot.routes().next_hop(robot.client(up), kLadar).to, nullptr) << "and never back";
}

TEST_F(RoutesTest, APeerIsAskedForItsOwnSystem) {
  const ClientId up = link(LinkKind::kSuper, 0, "base");
  const ClientId peer = link(LinkKind::kPeer, 2, "robot2");
  router_.set_uplink(now_, up);
  const ClientId local = connect();
  EXPECT_EQ(hop_of(local, Address(0x02140000)), peer);
  EXPECT_EQ(hop_of(local, Address(0x03140000)), up);
  EXPECT_EQ(hop_of(up, Address(0x02140000)), kNoClient) << "what comes from above goes down only";
}

TEST_F(RoutesTest, WhatComesFromAboveGoesDownOnly) {
  const ClientId up = link(LinkKind::kSuper, 0, "base");
  const ClientId peer = link(LinkKind::kPeer, 2, "robot2");
  const ClientId sub = link(LinkKind::kSub, 1, "host");
  router_.learn(now_, peer, kLadar, kRobot);
  router_.learn(now_, sub, kPilot, kFar);
  EXPECT_EQ(hop_of(up, kPilot), sub);
  EXPECT_EQ(hop_of(up, kLadar), kNoClient);
  EXPECT_EQ(router_.routes().next_hop(router_.client(up), kLadar).why_not, Outcome::kWouldReturn);
  EXPECT_EQ(hop_of(sub, kLadar), peer);
}

TEST_F(RoutesTest, AStaticRouteGoesBeforeTheUplink) {
  const ClientId up = link(LinkKind::kSuper, 0, "base");
  const ClientId sub = link(LinkKind::kSub, 3, "robot3");
  router_.set_uplink(now_, up);
  router_.set_static_routes({{*AddressPattern::parse("Ladar(3/*)"), std::string_view("Ladar(3/*)"),
                              std::string_view("robot3")}});
  const ClientId local = connect();
  EXPECT_EQ(hop_of(local, Address(0x03140000)), sub);
  EXPECT_EQ(hop_of(local, Address(0x03150000)), up);
}

// What a link brings is checked against who is behind it.
TEST_F(RoutesTest, SourcesAndMailboxesMustBelongBehindTheLink) {
  const ClientId up = link(LinkKind::kSuper, 0, "base");
  const ClientId robot3 = link(LinkKind::kSub, 3, "robot3");
  const ClientId robot4 = link(LinkKind::kPeer, 4, "robot4");
  const Address here(0x00110000);
  const ClientId local = connect();
  router_.register_mailbox(now_, local, here);
  ASSERT_TRUE(router_.learn(now_, robot3, Address(0x03110000), kRobot));
  const auto may = [&](ClientId from, Address address) {
    return router_.routes().may_come_from(*router_.client(from), address);
  };
  EXPECT_TRUE(may(robot3, Address(0x03110000)));
  EXPECT_TRUE(may(robot3, Address(0x03770000))) << "not announced yet, or any more";
  EXPECT_FALSE(may(robot3, Address(0x04110000)));
  EXPECT_FALSE(may(robot3, here));
  EXPECT_TRUE(may(robot4, Address(0x04110000)));
  EXPECT_FALSE(may(robot4, Address(0x03110000)));
  EXPECT_TRUE(may(up, Address(0x05110000)));
  EXPECT_FALSE(may(up, here));
  EXPECT_FALSE(may(up, Address(0x03110000)));
  EXPECT_EQ(send(robot3, {.type = 3, .dest = here, .src = Address(0x04110000)}),
            Outcome::kForgedSource);
}

}  // namespace routes_test
}  // namespace tims::core::test
