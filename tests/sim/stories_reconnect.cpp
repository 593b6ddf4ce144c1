// Complaints about reconnecting: "process alive, log clean, no data; restarting one side fixed it".
#include "router/core/random.h"
#include "tests/sim/story.h"

namespace tims::sim {
namespace stories_reconnect {

TEST(Reconnect, AllNodesReachEachOther) {
  Story s;
  s.begin();
  EXPECT_TRUE(s.gui_reaches_camera());
  EXPECT_TRUE(s.reaches(*s.host, s.camera, kCamera, *s.base, s.gui, kGui));
  EXPECT_TRUE(s.reaches(*s.host, s.camera, kCamera, *s.other, s.chassis, kChassis));
}

TEST(Reconnect, TheUpperRouterWasRestarted) {
  Story s;
  s.begin();
  s.base->kill();
  s.base->start(s.now());
  s.gui = s.client(*s.base, kGui);
  EXPECT_TRUE(s.run_until([&] { return s.converged(); }, 2s));
  EXPECT_TRUE(s.gui_reaches_camera());
}

// Routers repeat their registrations. A router that took these for lost commands would answer
// itself.
TEST(Reconnect, MessagesBetweenRoutersAreNotCountedAsLost) {
  Story s;
  s.begin();
  s.cut("robot", "base");
  s.client(*s.robot, Address(0x01140001));  // must be reported to the base
  s.run_for(20ms);
  s.base->kill();
  s.base->start(s.now());
  s.cut("robot", "base", false);
  EXPECT_TRUE(s.run_until([&] { return s.converged(); }, 2s));
  s.run_for(1s);
  for (const Node* node : {s.base, s.robot})
    for (std::size_t c = 0; c < core::kClasses; ++c)
      EXPECT_EQ(node->lost(c), 0U) << node->setup().name << " class " << c;
}

TEST(Reconnect, TheLowerRouterWasRestarted) {
  Story s;
  s.begin();
  s.robot->kill();
  s.run_for(50ms);
  s.robot->start(s.now());
  s.ladar = s.client(*s.robot, kLadar);
  EXPECT_TRUE(s.run_until([&] { return Story::knows(*s.robot, kCamera); }, 2s));
  EXPECT_TRUE(s.run_until([&] { return s.converged(); }, 2s));
  EXPECT_TRUE(s.gui_reaches_camera());
}

// It exits after it has written what its local readers wait for, up to 2 s later.
TEST(Reconnect, ARouterThatSentCloseDoesNotReconnect) {
  Story s;
  s.begin();
  EXPECT_EQ(Story::links_up(*s.base), 2U);
  s.robot->links().end(s.now());
  s.robot->end_turn(s.now());
  s.robot->send(s.now(), s.ladar, {.type = 3, .dest = kGui, .src = kLadar});
  s.run_for(2s);
  EXPECT_EQ(Story::links_up(*s.base), 1U);
  EXPECT_EQ(Story::links_up(*s.robot), 0U);
  EXPECT_FALSE(Story::knows(*s.base, kLadar));
}

// One side has lost the session, the other has not.
TEST(Reconnect, AHalfOpenSession) {
  Story s;
  s.begin();
  s.cut("robot", "base");
  s.base->kill();
  s.base->start(s.now());
  s.gui = s.client(*s.base, kGui);
  s.run_for(500ms);  // the robot still takes the link for up
  s.cut("robot", "base", false);
  EXPECT_TRUE(s.run_until([&] { return s.converged(); }, 1s));
}

TEST(Reconnect, TheRobotGetsAnotherAddress) {
  Story s;
  s.begin();
  const auto up_before = s.robot->events.size();
  s.move(*s.robot, address_of(500), 200ms);
  EXPECT_TRUE(s.reaches(*s.robot, s.ladar, kLadar, *s.base, s.gui, kGui));
  EXPECT_TRUE(s.run_until([&] { return s.gui_reaches_camera(); }, 1s));
  s.run_for(2s);
  EXPECT_EQ(s.robot->events.size(), up_before) << "the link to the base went down";
}

TEST(Reconnect, TheUpperRouterGetsAnotherAddress) {
  Story s;
  s.begin();
  s.move(*s.base, address_of(501), 10s);  // long before its name resolves to it
  EXPECT_TRUE(s.reaches(*s.base, s.gui, kGui, *s.robot, s.ladar, kLadar));
  EXPECT_TRUE(s.run_until(
      [&] { return s.reaches(*s.robot, s.ladar, kLadar, *s.base, s.gui, kGui, 100ms); }, 1s));
}

// UDP's checksum detects nearly all damage, but not all. A damaged byte stream stays damaged, which
// is detected by a table that stays wrong.
TEST(Reconnect, DamagedLanesAreRestarted) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Story s(seed);
    std::uint64_t state = seed;
    const auto random = [&] { return core::next_random(state); };
    bool damaging = false;
    std::uint64_t damaged = 0;
    s.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
      if (!damaging || bytes.size() < 60 || random() % 2 == 0) return false;
      std::vector<std::byte> copy(bytes.begin(), bytes.end());
      copy[20 + random() % (copy.size() - 20)] ^= static_cast<std::byte>(1 + random() % 255);
      s.inject(from.address(), to, copy);
      ++damaged;
      return true;
    };
    s.begin();
    damaging = true;
    for (std::uint32_t i = 0; i < 10; ++i) {
      s.client(*s.host, Address(kCamera.raw() + 1 + i));
      s.run_for(20ms);
    }
    damaging = false;
    const auto all_known = [&] {
      for (std::uint32_t i = 0; i < 10; ++i)
        if (!Story::knows(*s.base, Address(kCamera.raw() + 1 + i))) return false;
      return s.converged();
    };
    EXPECT_TRUE(s.run_until(all_known, 30s)) << "seed " << seed;
    EXPECT_GT(damaged, 0U);
  }
}

// The network comes up after the router; until then its target has no address.
TEST(Reconnect, AnInterfaceComesLate) {
  Story s;
  Node& late = s.add({.name = "late",
                      .role = core::Role::kSystem,
                      .system = 7,
                      .links = {{.kind = core::LinkKind::kSuper, .to = "base.local:2010"}}});
  s.begin();
  late.start(s.now());
  s.run_for(60s);
  EXPECT_EQ(late.links().names_to_resolve(), std::vector<std::string>{"base.local:2010"});
  late.links().set_target(s.now(), "base.local:2010", s.base->address());
  late.end_turn(s.now());
  EXPECT_TRUE(s.run_until([&] { return Story::links_up(late) == 1; }, 500ms));
}

TEST(Reconnect, AWiFiBlackoutOfMinutes) {
  Story s;
  s.begin();
  s.cut("robot", "base");
  std::vector<std::byte> body(50'000);
  std::size_t most = 0;
  for (int i = 0; i < 1800; ++i) {
    s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kGui, .src = kLadar}, body);
    s.run_for(100ms);
    most = std::max(most, s.robot->memory_in_use());
  }
  EXPECT_LE(most, 17U << 20);
  s.cut("robot", "base", false);
  EXPECT_TRUE(s.run_until([&] { return s.converged(); }, 1s));
  EXPECT_TRUE(s.gui_reaches_camera());
}

// The robot receives from the base, but not the base from the robot.
TEST(Reconnect, AsymmetricLoss) {
  Story s;
  s.begin();
  s.cut_one_way("robot", "base");
  EXPECT_TRUE(s.run_until([&] { return !Story::knows(*s.base, kCamera); }, 3 * kKeepAlive + 100ms));
  // The robot learns that the base does not receive it, and answers commands with NOT_AVAILABLE.
  EXPECT_TRUE(
      s.run_until([&] { return s.robot->router().routes().uplink() == core::kNoClient; }, 500ms));
  s.robot->send(s.now(), s.ladar, {.type = 3, .dest = kGui, .src = kLadar});
  EXPECT_EQ(Story::not_available(*s.robot, s.ladar), 1U);
  s.cut_one_way("robot", "base", false);
  EXPECT_TRUE(s.run_until([&] { return s.converged(); }, 1s));
}

// One side sends keep-alives often, the other seldom.
TEST(Reconnect, EachSideHasItsOwnKeepAlive) {
  SimulatedNetwork w(6);
  auto sub = sub_link();
  auto super = super_link(address_of(0));
  sub.keep_alive = 50ms;
  super.keep_alive = 1s;
  Node& base = w.add({.name = "base", .role = core::Role::kTop, .links = {sub}});
  Node& robot = w.add({.name = "robot", .system = 1, .links = {super}});
  for (Node* node : {&base, &robot}) node->start(w.now());
  w.run_for(20s);
  EXPECT_EQ(Story::find_event(base, core::EventKind::kLinkDown), nullptr);
  EXPECT_EQ(Story::find_event(robot, core::EventKind::kLinkDown), nullptr);
  w.cut("robot", "base");
  w.run_for(100ms);
  EXPECT_EQ(Story::links_up(robot), 1U);
  w.run_for(100ms);
  EXPECT_EQ(Story::links_up(robot), 0U);
  EXPECT_EQ(Story::links_up(base), 1U);
  w.run_for(3s);
  EXPECT_EQ(Story::links_up(base), 0U);
}

// Keep-alive intervals are negotiated per session: the other side keeps the agreed timeout.
TEST(Reconnect, AnotherKeepAliveDoesNotTearALinkDown) {
  for (const bool above : {false, true}) {
    Story s;
    s.begin();
    Node& node = above ? *s.base : *s.robot;
    auto links = node.setup().links;
    for (link::LinkSettings& link : links) link.keep_alive = 2s;
    node.links().configure(s.now(), links);
    node.end_turn(s.now());
    s.run_for(20s);
    EXPECT_EQ(Story::find_event(*s.base, core::EventKind::kLinkDown), nullptr);
    // The next session uses the new interval.
    s.cut("robot", "base");
    s.run_for(10s);
    s.cut("robot", "base", false);
    s.run_for(5s);
    const std::size_t events = s.base->events.size();
    s.run_for(20s);
    EXPECT_EQ(s.base->events.size(), events);
    EXPECT_TRUE(s.gui_reaches_camera());
    EXPECT_TRUE(s.reaches(*s.host, s.camera, kCamera, *s.base, s.gui, kGui));
  }
}

TEST(Reconnect, AnMtuBlackHole) {
  Story s;
  s.begin();
  std::vector<std::byte> body(200'000);
  const auto send = [&] {
    return s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kGui, .src = kLadar}, body);
  };
  send();
  s.run_for(2s);
  ASSERT_EQ(s.base->arrivals(s.gui).size(), 1U);
  s.set_faults({.delay = 1ms, .mtu = 1200});
  EXPECT_GT(s.robot->links().uplink()->session().mtu(), link::kDatagramBase);
  send();
  EXPECT_TRUE(s.run_until([&] { return s.base->arrivals(s.gui).size() == 2; }, 2s));
  EXPECT_EQ(s.robot->links().uplink()->session().mtu(), link::kDatagramBase);
}

// A VPN in a tunnel: 1124 bytes with IP and UDP. The link is up, and what it carries arrives.
TEST(Reconnect, APathOfLessThan1200Bytes) {
  for (const std::size_t carries : {1096U, 548U}) {
    Story s;
    s.begin();
    s.set_faults({.delay = 5ms, .mtu = carries});
    const std::vector<std::byte> body(200'000);
    for (std::size_t n = 1; n <= 3; ++n) {
      s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kGui, .src = kLadar}, body);
      EXPECT_TRUE(s.run_until([&] { return s.base->arrivals(s.gui).size() == n; }, 10s)) << n;
    }
    const auto* link = s.robot->links().uplink();
    ASSERT_NE(link, nullptr) << "it stays up";
    EXPECT_LE(link->session().mtu(), carries);
    EXPECT_GE(link->session().mtu(), carries > 1000 ? 1064U : 548U);
  }
}

// No later message reveals the loss; the message is retransmitted in small datagrams.
TEST(Reconnect, OneMessageInAnMtuBlackHole) {
  Story s;
  s.begin();
  const auto mtu = [&] { return s.robot->links().uplink()->session().mtu(); };
  ASSERT_TRUE(s.run_until([&] { return mtu() > 1400; }, 5s));
  s.run_for(100ms);
  s.set_faults({.delay = 1ms, .mtu = 1200});
  const std::vector<std::byte> body(1350);
  s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kGui, .src = kLadar}, body);
  EXPECT_TRUE(s.run_until([&] { return s.base->arrivals(s.gui).size() == 1; }, 15ms));
}

TEST(Reconnect, TheWallClockJumps) {
  Story s;
  s.begin();
  const std::size_t events = s.robot->events.size();
  s.robot->jump_wall(-48h);
  s.base->jump_wall(24h * 365);
  s.run_for(5s);
  EXPECT_EQ(s.robot->events.size(), events);
  EXPECT_TRUE(s.gui_reaches_camera());
}

// A link taken down by command stays down until it is brought up.
TEST(Reconnect, ALinkTakenDownByCommandStaysDown) {
  Story s;
  s.begin();
  EXPECT_TRUE(s.base->links().act(s.now(), "robot", link::Links::Action::kDown));
  s.base->end_turn(s.now());
  s.run_for(10s);
  EXPECT_FALSE(Story::knows(*s.base, kLadar));
  const core::Event* refused = Story::find_event(*s.robot, core::EventKind::kLinkRefused);
  ASSERT_NE(refused, nullptr);
  EXPECT_NE(refused->text.view().find("manually"), std::string_view::npos);
  EXPECT_TRUE(s.base->links().act(s.now(), "robot", link::Links::Action::kUp));
  s.base->end_turn(s.now());
  EXPECT_TRUE(s.run_until([&] { return s.converged(); }, 5s));
}

}  // namespace stories_reconnect
}  // namespace tims::sim
