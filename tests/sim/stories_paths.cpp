// Links with two ways: UDP, and DDS beside it. Complaints about what happens when one of them dies.
#include "tests/sim/story.h"

namespace tims::sim {
namespace stories_paths {

using link::PathKind;

const link::Link& link_of(Node& node, const std::string& peer) {
  const link::Link* found = nullptr;
  node.links().for_each([&](const link::Link& link) {
    if (link.peer().name.view() == peer) found = &link;
  });
  if (found == nullptr) throw std::out_of_range("no link to " + peer);
  return *found;
}

// A base and a robot that have both ways to each other; DDS takes five times as long.
class Paths : public testing::Test {
 protected:
  explicit Paths(std::uint64_t seed = 1) : network(seed) {}

  static constexpr Duration kUdpDelay = 1ms;
  static constexpr Duration kDdsDelay = 5ms;

  void start(const std::vector<PathKind>& paths = {PathKind::kUdp, PathKind::kDds}) {
    start(paths, paths, kKeepAlive);
  }
  void start(const std::vector<PathKind>& robots, const std::vector<PathKind>& bases,
             Duration keep_alive) {
    link::LinkSettings below = sub_link();
    link::LinkSettings above = super_link(address_of(0));
    below.paths = bases;
    above.paths = robots;
    below.keep_alive = above.keep_alive = keep_alive;
    base = &network.add(
        {.name = "base", .role = core::Role::kTop, .links = {below}, .fleet = "harbour"});
    robot = &network.add({.name = "robot", .system = 1, .links = {above}, .fleet = "harbour"});
    network.set_faults({.delay = kUdpDelay});
    set_dds({.delay = kDdsDelay});
    base->start(network.now());
    robot->start(network.now());
    gui = client(*base, kGui);
    ladar = client(*robot, kLadar);
    ASSERT_TRUE(network.run_until([&] { return Story::knows(*base, kLadar); }, 2s));
    network.run_for(3s);  // both ways are known
  }
  core::ClientId client(Node& node, Address address) {
    const auto id = node.add_client(network.now(), address.to_string());
    EXPECT_TRUE(node.add_mailbox(network.now(), id, address));
    return id;
  }
  void set_dds(const Faults& faults) {
    network.set_faults("base", "robot", faults, PathKind::kDds);
    network.set_faults("robot", "base", faults, PathKind::kDds);
  }
  // From the robot's ladar to the base's GUI.
  void report(std::size_t size, std::uint8_t priority, std::uint8_t flags = 0) {
    robot->send(network.now(), ladar,
                {.flags = flags,
                 .type = flags == 0 ? std::int8_t{3} : type::kData,
                 .priority = priority,
                 .dest = kGui,
                 .src = kLadar},
                std::vector<std::byte>(size));
  }
  [[nodiscard]] const std::vector<Arrival>& reports() { return base->arrivals(gui); }
  void cut(PathKind kind, bool blackout = true) { network.cut("base", "robot", blackout, kind); }
  PathKind used(Node& node) {
    return link_of(node, &node == base ? "robot" : "base").paths().kind();
  }
  // A command every few milliseconds, both ways, for so long.
  void talk(Duration time, Duration each = 7ms) {
    const Time end = network.now() + time;
    while (network.now() < end) {
      ++number;
      send(*base, gui, kGui, kLadar);
      send(*robot, ladar, kLadar, kGui);
      network.run_for(each);
    }
  }
  void send(Node& node, core::ClientId id, Address src, Address dest) {
    node.send(network.now(), id,
              {.type = 3,
               .priority = 100,
               .seq_nr = static_cast<std::uint8_t>(number),
               .dest = dest,
               .src = src});
  }
  // All that was sent has come, once each and in order.
  void expect_all() {
    const auto all = [&] {
      return base->arrivals(gui).size() == number && robot->arrivals(ladar).size() == number;
    };
    EXPECT_TRUE(network.run_until(all, 5s));
    for (const auto& numbers : {sequence(*base, gui), sequence(*robot, ladar)}) {
      ASSERT_EQ(numbers.size(), number);
      for (std::size_t i = 0; i < numbers.size(); ++i)
        ASSERT_EQ(numbers[i], static_cast<std::uint8_t>(i + 1));
    }
  }
  static std::vector<std::uint8_t> sequence(Node& node, core::ClientId id) {
    std::vector<std::uint8_t> numbers;
    for (const Arrival& a : node.arrivals(id)) numbers.push_back(a.header.seq_nr);
    return numbers;
  }
  [[nodiscard]] static std::size_t count(const Node& node, core::EventKind kind) {
    return static_cast<std::size_t>(std::ranges::count(node.events, kind, &core::Event::kind));
  }

  SimulatedNetwork network;
  Node* base = nullptr;
  Node* robot = nullptr;
  core::ClientId gui{};
  core::ClientId ladar{};
  std::size_t number = 0;
};

TEST_F(Paths, TheFirstIsUsedWhileItWorks) {
  start();
  talk(10s);
  EXPECT_EQ(used(*base), PathKind::kUdp);
  EXPECT_EQ(used(*robot), PathKind::kUdp);
  expect_all();
  EXPECT_EQ(count(*base, core::EventKind::kLinkPath), 0U);
}

TEST_F(Paths, WhatADeadWayCarriedGoesOnOverTheOtherWithinThreeKeepAlives) {
  start();
  talk(1s);
  cut(PathKind::kUdp);
  const Time cut_at = network.now();
  const std::size_t before = robot->arrivals(ladar).size();
  while (robot->arrivals(ladar).size() < before + 3) talk(7ms);
  EXPECT_LE(network.now() - cut_at, 3 * kKeepAlive);
  talk(3s);
  EXPECT_EQ(used(*base), PathKind::kDds);
  EXPECT_EQ(used(*robot), PathKind::kDds);
  expect_all();
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 0U);
  EXPECT_EQ(count(*base, core::EventKind::kLinkPath), 1U);
}

TEST_F(Paths, TheBetterOneIsTakenBackWhenItHasWorkedForAWhile) {
  start();
  cut(PathKind::kUdp);
  talk(3s);
  cut(PathKind::kUdp, false);
  talk(2s);
  EXPECT_EQ(used(*base), PathKind::kDds) << "not at once";
  talk(4s);
  EXPECT_EQ(used(*base), PathKind::kUdp);
  EXPECT_EQ(used(*robot), PathKind::kUdp);
  expect_all();
  EXPECT_EQ(count(*robot, core::EventKind::kLinkDown), 0U);
  EXPECT_EQ(count(*robot, core::EventKind::kLinkPath), 2U);
}

TEST_F(Paths, AFilterInOneDirectionSendsThatDirectionTheOtherWay) {
  start();
  network.cut_one_way("robot", "base", true, PathKind::kUdp);
  talk(10s);
  EXPECT_EQ(used(*robot), PathKind::kDds);
  EXPECT_EQ(used(*base), PathKind::kUdp);
  expect_all();
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 0U);
}

TEST_F(Paths, AFilterOfWhatTheBaseSendsLeavesTheRobotsDirectionAlone) {
  start();
  network.cut_one_way("base", "robot", true, PathKind::kUdp);
  talk(10s);
  EXPECT_EQ(used(*base), PathKind::kDds);
  EXPECT_EQ(used(*robot), PathKind::kUdp);
  expect_all();
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 0U);
}

TEST_F(Paths, OneWayEachInOppositeDirectionsIsEnough) {
  start();
  network.cut_one_way("base", "robot", true, PathKind::kUdp);
  talk(3s);
  network.cut_one_way("robot", "base", true, PathKind::kDds);
  talk(10s);
  EXPECT_EQ(used(*base), PathKind::kDds);
  EXPECT_EQ(used(*robot), PathKind::kUdp);
  expect_all();
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 0U);
}

TEST_F(Paths, AWayThatComesAndGoesIsNoNews) {
  start();
  for (const Duration half : {500ms, 800ms, 4000ms}) {
    const std::size_t before = count(*base, core::EventKind::kLinkPath);
    const Time end = network.now() + 5min;
    while (network.now() < end) {
      cut(PathKind::kUdp);
      talk(half, 50ms);
      cut(PathKind::kUdp, false);
      talk(half, 50ms);
    }
    EXPECT_LE(count(*base, core::EventKind::kLinkPath), before + 16);
    talk(70s, 50ms);
    EXPECT_EQ(used(*base), PathKind::kUdp);
    ASSERT_NO_FATAL_FAILURE(expect_all());
  }
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 0U);
}

TEST_F(Paths, ALargeMessageInManyPiecesSurvivesAFailOver) {
  start();
  const Faults slow{.delay = kUdpDelay, .rate = 2'000'000};
  network.set_faults("robot", "base", slow);
  for (int i = 0; i < 3; ++i) report(1U << 20, 100);
  network.run_for(700ms);  // in the midst of the second
  ASSERT_EQ(reports().size(), 1U);
  cut(PathKind::kUdp);
  EXPECT_TRUE(network.run_until([&] { return reports().size() == 3; }, 3s));
  for (const Arrival& one : reports()) EXPECT_EQ(one.body.size(), 1U << 20);
  EXPECT_EQ(used(*robot), PathKind::kDds);
}

TEST_F(Paths, WhatIsUrgentOvertakesWhatWaitsForTheFailOver) {
  start();
  cut(PathKind::kUdp);
  network.run_for(20ms);
  for (int i = 0; i < 8; ++i) report(1U << 20, 10);
  network.run_for(100ms);
  report(0, 255);
  EXPECT_TRUE(network.run_until([&] { return !reports().empty(); }, 3 * kKeepAlive));
  EXPECT_EQ(reports().front().header.priority, 255);
}

TEST_F(Paths, SamplesGoOnAndNeverBackwards) {
  start();
  for (int i = 0; i < 300; ++i) {
    if (i == 100) cut(PathKind::kUdp);
    report(static_cast<std::size_t>(i), 100, flag::kStream);
    network.run_for(20ms);
  }
  network.run_for(1s);
  EXPECT_GE(reports().size(), 260U) << "those of 700 ms are lost, at most";
  for (std::size_t i = 1; i < reports().size(); ++i)
    EXPECT_GT(reports()[i].body.size(), reports()[i - 1].body.size());
  EXPECT_EQ(reports().back().body.size(), 299U);
}

TEST_F(Paths, ALongWayRoundIsAWay) {
  start();
  set_dds({.delay = 100ms});
  network.run_for(3s);
  cut(PathKind::kUdp);
  talk(20s);
  cut(PathKind::kUdp, false);
  talk(10s);
  expect_all();
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 0U);
  EXPECT_EQ(count(*base, core::EventKind::kLinkPath), 2U);
}

TEST_F(Paths, ShortKeepAlivesFindADeadWaySoon) {
  start({PathKind::kUdp, PathKind::kDds}, {PathKind::kUdp, PathKind::kDds}, 50ms);
  talk(1s);
  cut(PathKind::kUdp);
  talk(150ms);
  EXPECT_EQ(used(*base), PathKind::kDds);
  EXPECT_EQ(used(*robot), PathKind::kDds);
  expect_all();
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 0U);
}

TEST_F(Paths, LongKeepAlivesTakeTheirTime) {
  start({PathKind::kUdp, PathKind::kDds}, {PathKind::kUdp, PathKind::kDds}, 10s);
  network.run_for(1min);
  cut(PathKind::kUdp);
  network.run_for(31s);
  EXPECT_EQ(used(*base), PathKind::kDds);
  EXPECT_EQ(used(*robot), PathKind::kDds);
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 0U);
}

TEST_F(Paths, AWayThatOnlyOneSideHasIsNone) {
  start({PathKind::kUdp, PathKind::kDds}, {PathKind::kUdp}, kKeepAlive);
  EXPECT_FALSE(link_of(*robot, "base").paths().find(PathKind::kDds)->works);
  cut(PathKind::kUdp);
  network.run_for(5s);
  EXPECT_EQ(used(*robot), PathKind::kUdp);
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 1U);
  EXPECT_EQ(count(*robot, core::EventKind::kLinkDown), 1U);
  std::string refusal(link_of(*robot, "base").refusal().view());
  EXPECT_NE(refusal.find("takes no link over dds"), std::string::npos) << refusal;
  cut(PathKind::kUdp, false);
  EXPECT_TRUE(network.run_until([&] { return Story::knows(*base, kLadar); }, 4s));
  talk(1s);
  expect_all();
}

// Its answer is RESET: the token means nothing to it.
TEST_F(Paths, WhoeverHasTheirOldAddressDoesNotEndTheLink) {
  start();
  talk(1s);
  const NetAddress old = base->address();
  network.move(*base, address_of(77), 1h);  // nobody tells the robot
  cut(PathKind::kUdp);                      // nor does it get there
  talk(2s);
  Node& stranger = network.add({.name = "stranger", .system = 9});
  stranger.move_to(old);
  stranger.start(network.now());
  talk(10s);
  EXPECT_EQ(used(*robot), PathKind::kDds);
  expect_all();
  EXPECT_EQ(count(*robot, core::EventKind::kLinkDown), 0U);
}

TEST_F(Paths, WhenBothAreDeadTheLinkIs) {
  start();
  talk(1s);
  cut(PathKind::kUdp);
  talk(2s);
  cut(PathKind::kDds);
  network.run_for(2s);
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 1U);
  cut(PathKind::kDds, false);
  EXPECT_TRUE(network.run_until([&] { return Story::knows(*base, kLadar); }, 2s));
  talk(1s);
  EXPECT_EQ(used(*base), PathKind::kDds);
  cut(PathKind::kUdp, false);
  talk(6s);
  EXPECT_EQ(used(*base), PathKind::kUdp);
}

TEST_F(Paths, ARouterThatMovesIsFoundAgainOverTheOtherWay) {
  start();
  talk(1s);
  network.move(*base, address_of(77), 1h);  // nobody tells the robot
  network.announce(*base);
  talk(8s);
  EXPECT_EQ(used(*robot), PathKind::kUdp);
  EXPECT_EQ(link_of(*robot, "base").address(), address_of(77));
  expect_all();
  EXPECT_EQ(count(*robot, core::EventKind::kLinkDown), 0U);
}

TEST_F(Paths, WithoutUdpALinkComesUpOverDds) {
  start({PathKind::kDds});
  talk(1s);
  EXPECT_EQ(used(*base), PathKind::kDds);
  cut(PathKind::kUdp);
  talk(2s);
  expect_all();
}

// Cut at random, one way and the other, in one direction or both: nothing reliable is lost.
TEST_F(Paths, AThousandRandomCutsLoseNothing) {
  start();
  for (int cuts = 0; cuts < 1000; ++cuts) {
    const PathKind kind = network.random(2) == 0 ? PathKind::kUdp : PathKind::kDds;
    const std::uint64_t which = network.random(3);
    if (which != 0) network.cut_one_way("base", "robot", true, kind);
    if (which != 1) network.cut_one_way("robot", "base", true, kind);
    talk(std::chrono::milliseconds(network.random(2500)), 23ms);
    cut(kind, false);
    talk(std::chrono::milliseconds(1200 + network.random(4000)), 23ms);
    // Enough to compare, not enough to fill the memory.
    ASSERT_NO_FATAL_FAILURE(expect_all()) << "cut " << cuts;
    base->forget_arrivals(gui);
    robot->forget_arrivals(ladar);
    number = 0;
  }
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 0U);
}

TEST_F(Paths, ADeadWayIsNoLoss) {
  start();
  cut(PathKind::kUdp);
  network.run_for(30s);
  EXPECT_EQ(link_of(*base, "robot").session().loss_permille(), 0);
  EXPECT_EQ(link_of(*robot, "base").session().loss_permille(), 0);
  set_dds({.loss = 0.2, .delay = kDdsDelay});
  // What it says follows the last few datagrams: their share of a minute counts.
  int sum = 0;
  for (int second = 0; second < 60; ++second) {
    network.run_for(1s);
    sum += link_of(*base, "robot").session().loss_permille();
  }
  EXPECT_NEAR(sum / 60, 200, 100);
}

TEST_F(Paths, ASlowWayWithLossesIsStillOne) {
  start();
  set_dds({.loss = 0.1, .delay = 80ms, .jitter = 20ms});
  cut(PathKind::kUdp);
  talk(20s);
  expect_all();
  EXPECT_EQ(used(*base), PathKind::kDds);
}

}  // namespace stories_paths
}  // namespace tims::sim
