// Links with two paths, UDP and DDS; complaints about what happens when one of them fails.
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

// A base and a robot with both paths between them; DDS has five times the delay.
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
    network.run_for(3s);  // both paths are known to work
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
  // Sends a command every `each` in both directions, for `time`.
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
  // Everything that was sent has arrived once and in order.
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

TEST_F(Paths, TheFirstPathIsUsedWhileItWorks) {
  start();
  talk(10s);
  EXPECT_EQ(used(*base), PathKind::kUdp);
  EXPECT_EQ(used(*robot), PathKind::kUdp);
  expect_all();
  EXPECT_EQ(count(*base, core::EventKind::kLinkPath), 0U);
}

TEST_F(Paths, MessagesOfAFailedPathGoOverTheOtherWithinThreeKeepAlives) {
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

TEST_F(Paths, ThePreferredPathIsUsedAgainAfterItHasWorkedForAWhile) {
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

TEST_F(Paths, AFilterInOneDirectionMovesThatDirectionToTheOtherPath) {
  start();
  network.cut_one_way("robot", "base", true, PathKind::kUdp);
  talk(10s);
  EXPECT_EQ(used(*robot), PathKind::kDds);
  EXPECT_EQ(used(*base), PathKind::kUdp);
  expect_all();
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 0U);
}

TEST_F(Paths, AFilterOfTheBasesDatagramsDoesNotMoveTheRobotsDirection) {
  start();
  network.cut_one_way("base", "robot", true, PathKind::kUdp);
  talk(10s);
  EXPECT_EQ(used(*base), PathKind::kDds);
  EXPECT_EQ(used(*robot), PathKind::kUdp);
  expect_all();
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 0U);
}

TEST_F(Paths, OnePathPerDirectionIsEnough) {
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

TEST_F(Paths, AnIntermittentPathIsNotReportedEveryTime) {
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
  network.run_for(700ms);  // during the transfer of the second
  ASSERT_EQ(reports().size(), 1U);
  cut(PathKind::kUdp);
  EXPECT_TRUE(network.run_until([&] { return reports().size() == 3; }, 3s));
  for (const Arrival& one : reports()) EXPECT_EQ(one.body.size(), 1U << 20);
  EXPECT_EQ(used(*robot), PathKind::kDds);
}

TEST_F(Paths, UrgentMessagesOvertakeThoseWaitingForTheFailOver) {
  start();
  cut(PathKind::kUdp);
  network.run_for(20ms);
  for (int i = 0; i < 8; ++i) report(1U << 20, 10);
  network.run_for(100ms);
  report(0, 255);
  EXPECT_TRUE(network.run_until([&] { return !reports().empty(); }, 3 * kKeepAlive));
  EXPECT_EQ(reports().front().header.priority, 255);
}

TEST_F(Paths, SamplesContinueInOrder) {
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

TEST_F(Paths, APathWithLongRoundTripsIsUsed) {
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

TEST_F(Paths, ShortKeepAlivesDetectAFailedPathSoon) {
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

TEST_F(Paths, APathThatOnlyOneSideHasIsNotUsed) {
  start({PathKind::kUdp, PathKind::kDds}, {PathKind::kUdp}, kKeepAlive);
  EXPECT_FALSE(link_of(*robot, "base").paths().find(PathKind::kDds)->works);
  cut(PathKind::kUdp);
  network.run_for(5s);
  EXPECT_EQ(used(*robot), PathKind::kUdp);
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 1U);
  EXPECT_EQ(count(*robot, core::EventKind::kLinkDown), 1U);
  std::string refusal(link_of(*robot, "base").refusal().view());
  EXPECT_NE(refusal.find("accepts no link over dds"), std::string::npos) << refusal;
  cut(PathKind::kUdp, false);
  EXPECT_TRUE(network.run_until([&] { return Story::knows(*base, kLadar); }, 4s));
  talk(1s);
  expect_all();
}

// Another router at that address answers RESET, because it does not know the token.
TEST_F(Paths, ARouterAtTheOldAddressDoesNotEndTheLink) {
  start();
  talk(1s);
  const NetAddress old = base->address();
  network.move(*base, address_of(77), 1h);  // the robot does not learn this
  cut(PathKind::kUdp);                      // and UDP is cut
  talk(2s);
  Node& stranger = network.add({.name = "stranger", .system = 9});
  stranger.move_to(old);
  stranger.start(network.now());
  talk(10s);
  EXPECT_EQ(used(*robot), PathKind::kDds);
  expect_all();
  EXPECT_EQ(count(*robot, core::EventKind::kLinkDown), 0U);
}

TEST_F(Paths, WhenBothPathsFailTheLinkIsDown) {
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

TEST_F(Paths, ARouterThatMovesIsFoundAgainOverTheOtherPath) {
  start();
  talk(1s);
  network.move(*base, address_of(77), 1h);  // the robot does not learn this
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

// Random cuts of either path, in one direction or both, lose no reliable message.
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
    // Compared from time to time, so that the records do not fill the memory.
    ASSERT_NO_FATAL_FAILURE(expect_all()) << "cut " << cuts;
    base->forget_arrivals(gui);
    robot->forget_arrivals(ladar);
    number = 0;
  }
  EXPECT_EQ(count(*base, core::EventKind::kLinkDown), 0U);
}

TEST_F(Paths, AFailedPathDoesNotCountAsLoss) {
  start();
  cut(PathKind::kUdp);
  network.run_for(30s);
  EXPECT_EQ(link_of(*base, "robot").session().loss_permille(), 0);
  EXPECT_EQ(link_of(*robot, "base").session().loss_permille(), 0);
  set_dds({.loss = 0.2, .delay = kDdsDelay});
  // The value covers only the last few datagrams, so it is averaged over a minute.
  int sum = 0;
  for (int second = 0; second < 60; ++second) {
    network.run_for(1s);
    sum += link_of(*base, "robot").session().loss_permille();
  }
  EXPECT_NEAR(sum / 60, 200, 100);
}

TEST_F(Paths, ASlowPathWithLossesIsStillUsed) {
  start();
  set_dds({.loss = 0.1, .delay = 80ms, .jitter = 20ms});
  cut(PathKind::kUdp);
  talk(20s);
  expect_all();
  EXPECT_EQ(used(*base), PathKind::kDds);
}

}  // namespace stories_paths
}  // namespace tims::sim
