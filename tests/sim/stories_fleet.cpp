// Routers that discover each other by the name of their fleet; complaints about which routers link.
#include "tests/sim/story.h"

namespace tims::sim {
namespace stories_fleet {

using link::PathKind;

class Fleet : public testing::Test {
 protected:
  Fleet() : network(1) { network.set_faults({.delay = 1ms}); }

  Node& add(NodeSetup setup, bool accepts = true) {
    const std::vector both{PathKind::kUdp, PathKind::kDds};
    if (setup.fleet.empty()) setup.fleet = "harbour";
    link::LinkSettings below = sub_link();
    link::LinkSettings above{.kind = core::LinkKind::kSuper, .to = std::string(link::kAutomatic)};
    below.paths = above.paths = both;
    if (accepts && setup.role != core::Role::kSubsystem) setup.links.push_back(below);
    if (setup.role != core::Role::kTop) setup.links.push_back(above);
    Node& node = network.add(setup);
    node.start(network.now());
    return node;
  }
  Node& base() { return add({.name = "base", .role = core::Role::kTop, .id = 0}); }
  Node& robot(std::uint8_t system, std::uint8_t id = 1, bool accepts = true) {
    return add({.name = "robot" + std::to_string(system) + "-" + std::to_string(id),
                .system = system,
                .id = id},
               accepts);
  }
  Node& host(std::uint8_t system, std::uint8_t id = 2) {
    return add({.name = "host" + std::to_string(system),
                .role = core::Role::kSubsystem,
                .system = system,
                .id = id});
  }
  // The name of the node's super router; empty: none.
  static std::string super_of(Node& node) {
    const link::Link* up = node.links().uplink();
    return up == nullptr ? "" : std::string(up->peer().name.view());
  }
  bool becomes(Node& node, const std::string& super, Duration within = 3s) {
    return network.run_until([&] { return super_of(node) == super; }, within);
  }

  // A base and its robots as soon as all links are up; few DDS paths are prepared by then.
  Node& all_up(std::uint8_t count) {
    Node& ship = base();
    for (std::uint8_t system = 1; system <= count; ++system) robots.push_back(&robot(system));
    EXPECT_TRUE(network.run_until([&] { return Story::links_up(ship) == count; }, 5s));
    return ship;
  }
  Node& fifty_up() { return all_up(50); }
  // The number of routers to which a DDS path has been prepared.
  static std::size_t prepared(Node& node) {
    std::size_t n = 0;
    node.links().for_each([&](const link::Link& link) {
      n += link.paths().find(PathKind::kDds)->targets.empty() ? 0U : 1U;
    });
    return n;
  }
  std::size_t prepared_by_robots() {
    std::size_t n = 0;
    for (Node* node : robots) n += prepared(*node);
    return n;
  }
  static bool goes_by(Node& node, PathKind kind) {
    const link::Link* up = node.links().uplink();
    return up != nullptr && up->paths().kind() == kind;
  }
  std::size_t robots_by(PathKind kind) {
    return static_cast<std::size_t>(
        std::ranges::count_if(robots, [&](Node* node) { return goes_by(*node, kind); }));
  }

  SimulatedNetwork network;
  std::vector<Node*> robots;
};

// Whoever announces a router again and again makes the others look once in a while only.
TEST_F(Fleet, NewsOfOneMomentAreLookedAtTogether) {
  Node& one = robot(1);
  network.run_for(100ms);
  const auto place = [](std::uint8_t n) { return NetAddress::v4(10, 9, 9, n, 2010); };
  const auto announce = [&](std::uint8_t n) {
    link::Announcement news = one.announcement();
    news.identity.epoch = 99;
    news.identity.role = core::Role::kTop;
    news.identity.system = 0;
    news.dds = NetAddress::dds({7});
    news.udp = {place(n)};
    one.links().on_announced(network.now(), news);
    one.end_turn(network.now());
  };
  const auto calls = [&](std::uint8_t n) {
    bool found = false;
    one.links().for_each(
        [&](const link::Link& link) { found |= link.paths().is_target(place(n)); });
    return found;
  };
  announce(1);
  EXPECT_TRUE(calls(1)) << "at once";
  announce(2);
  announce(3);
  EXPECT_TRUE(calls(1));
  network.run_for(20ms);
  EXPECT_TRUE(calls(3));
  EXPECT_FALSE(calls(1));
}

TEST_F(Fleet, EachFindsItsSuperRouterByRoleAndSystem) {
  Node& ship = base();
  Node& one = robot(1);
  Node& two = robot(2);
  Node& host_of_two = host(2);
  EXPECT_TRUE(becomes(one, "base"));
  EXPECT_TRUE(becomes(two, "base"));
  EXPECT_TRUE(becomes(host_of_two, "robot2-1"));
  EXPECT_TRUE(network.run_until([&] { return Story::links_up(ship) == 2; }, 1s));
  EXPECT_EQ(one.links().uplink()->paths().kind(), PathKind::kUdp);
}

TEST_F(Fleet, ARouterWithoutSuperRouterWaitsAndReportsIt) {
  Node& below = host(3);
  network.run_for(5s);
  std::string refusal;
  below.links().for_each([&](const link::Link& l) { refusal = l.refusal().view(); });
  EXPECT_EQ(refusal, "the fleet has no router that is a system router of system 3");
  robot(3);
  EXPECT_TRUE(becomes(below, "robot3-1"));
}

TEST_F(Fleet, TwoFleetsDoNotDiscoverEachOther) {
  add({.name = "base", .role = core::Role::kTop, .id = 0, .fleet = "airport"});
  Node& one = robot(1);
  network.run_for(5s);
  EXPECT_EQ(super_of(one), "");
  EXPECT_TRUE(one.links().fleet().routers().empty());
}

TEST_F(Fleet, DdsIsUsedWhereUdpIsBlocked) {
  Node& ship = base();
  network.set_faults({.blackout = true});
  const auto open = [&](const std::string& from, const std::string& to) {
    network.set_faults(from, to, {.delay = 5ms}, PathKind::kDds);
  };
  Node& one = robot(1);
  open("base", "robot1-1");
  open("robot1-1", "base");
  EXPECT_TRUE(becomes(one, "base"));
  EXPECT_EQ(one.links().uplink()->paths().kind(), PathKind::kDds);
  EXPECT_TRUE(network.run_until([&] { return Story::links_up(ship) == 1; }, 1s));
}

TEST_F(Fleet, ARouterThatRefusesTheLinkIsNotAskedForEver) {
  robot(1, 1, false);
  robot(1, 3);
  Node& below = host(1);
  EXPECT_TRUE(becomes(below, "robot1-3", 10s));
}

TEST_F(Fleet, TwoRoutersWithOneIdAreReportedOnBothEnds) {
  Node& ship = base();
  Node& first = robot(1);
  EXPECT_TRUE(becomes(first, "base"));
  Node& second = add({.name = "impostor", .system = 1});
  network.run_for(5s);
  EXPECT_EQ(super_of(first), "base");
  EXPECT_EQ(super_of(second), "");
  for (Node* node : {&ship, &first, &second}) {
    const core::Event* event = Story::find_event(*node, core::EventKind::kDuplicateRouter);
    ASSERT_NE(event, nullptr) << node->setup().name;
  }
  std::string refusal;
  second.links().for_each([&](const link::Link& l) {
    if (l.settings().connects) refusal = l.refusal().view();
  });
  EXPECT_NE(refusal.find("robot1-1"), std::string::npos) << refusal;
}

TEST_F(Fleet, ARestartedSuperRouterIsFoundAgain) {
  Node& ship = base();
  Node& one = robot(1);
  EXPECT_TRUE(becomes(one, "base"));
  ship.kill();
  network.run_for(5s);
  EXPECT_EQ(super_of(one), "");
  EXPECT_TRUE(one.links().fleet().routers().empty()) << "old entries are removed after the lease";
  ship.start(network.now());
  EXPECT_TRUE(becomes(one, "base"));
}

TEST_F(Fleet, ARouterRestartedAtAnotherAddressIsFoundBeforeTheLeaseOfTheOldOneEnds) {
  Node& ship = base();
  Node& one = robot(1);
  EXPECT_TRUE(becomes(one, "base"));
  ship.kill();
  ship.move_to(address_of(60));
  ship.start(network.now());
  EXPECT_TRUE(becomes(one, "", 1s));
  EXPECT_TRUE(becomes(one, "base", 500ms));
  EXPECT_EQ(one.links().uplink()->address(), address_of(60));
}

TEST_F(Fleet, FiftyRobotsStartTogether) {
  Node& ship = base();
  for (std::uint8_t system = 1; system < 50; ++system) robot(system);
  EXPECT_TRUE(network.run_until([&] { return Story::links_up(ship) == 49; }, 5s));
}

TEST_F(Fleet, AFewDdsPathsArePreparedPerSecond) {
  Node& ship = fifty_up();
  std::size_t before = prepared(ship);
  EXPECT_LT(before, 15U);
  EXPECT_LT(prepared_by_robots(), 15U);
  for (int second = 0; second < 6; ++second) {
    network.run_for(1s);
    EXPECT_LE(prepared(ship), before + 20) << "ten, and ten saved";
    before = prepared(ship);
  }
  EXPECT_TRUE(
      network.run_until([&] { return prepared(ship) == 50 && prepared_by_robots() == 50; }, 40s));
  EXPECT_EQ(robots_by(PathKind::kUdp), 50U);
}

TEST_F(Fleet, ARouterThatLosesUdpDoesNotWaitForItsTurn) {
  Node& ship = fifty_up();
  network.run_for(10s);
  const std::size_t before = prepared(ship);
  std::vector<Node*> some;
  for (Node* node : robots) {
    if (prepared(*node) == 0 && some.size() < 5) some.push_back(node);
  }
  ASSERT_EQ(some.size(), 5U);
  for (Node* node : some) network.cut("base", node->setup().name, true, PathKind::kUdp);
  EXPECT_TRUE(network.run_until(
      [&] {
        return std::ranges::all_of(some, [](Node* n) { return goes_by(*n, PathKind::kDds); });
      },
      3s));
  EXPECT_LT(prepared(ship), before + 20) << "others have their turns";
}

// With more than a hundred routers, a DDS path is prepared only when UDP fails.
TEST_F(Fleet, InALargeFleetDdsPathsArePreparedOnDemand) {
  Node& ship = all_up(101);
  network.run_for(60s);
  EXPECT_EQ(prepared(ship), 0U);
  EXPECT_EQ(prepared_by_robots(), 0U);
  Node& one = *robots[7];
  network.cut("base", one.setup().name, true, PathKind::kUdp);
  EXPECT_TRUE(network.run_until([&] { return goes_by(one, PathKind::kDds); }, 3s));
  network.run_for(3s);
  EXPECT_TRUE(goes_by(one, PathKind::kDds));
  EXPECT_EQ(Story::links_up(ship), 101U);
  EXPECT_LE(prepared(ship), 1U);
  EXPECT_EQ(prepared_by_robots(), 1U);
}

TEST_F(Fleet, ARouterWithoutUdpDoesNotWaitForItsTurn) {
  fifty_up();
  Node& one = robot(60);
  network.cut("base", one.setup().name, true, PathKind::kUdp);
  EXPECT_TRUE(network.run_until([&] { return goes_by(one, PathKind::kDds); }, 11s));
}

TEST_F(Fleet, WhenAllLoseUdpTheirDdsPathsArePreparedInTurns) {
  Node& ship = fifty_up();
  for (Node* node : robots) network.cut("base", node->setup().name, true, PathKind::kUdp);
  network.run_for(2 * kKeepAlive);
  EXPECT_LE(prepared(ship), 20U);
  EXPECT_TRUE(network.run_until(
      [&] { return robots_by(PathKind::kDds) == 50 && Story::links_up(ship) == 50; }, 40s));
}

// Their leases at the base have expired by then, and each has a new DDS participant.
TEST_F(Fleet, AfterAPowerCutTheBasePreparesPathsInTurnsAgain) {
  Node& ship = fifty_up();
  network.run_for(40s);
  EXPECT_EQ(prepared(ship), 50U);
  for (Node* node : robots) node->kill();
  network.run_for(10s);
  for (Node* node : robots) node->start(network.now());
  EXPECT_TRUE(network.run_until([&] { return Story::links_up(ship) == 50; }, 5s));
  EXPECT_LT(prepared(ship), 15U);
}

}  // namespace stories_fleet
}  // namespace tims::sim
