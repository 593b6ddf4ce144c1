// Links with keys and two paths, or with addresses that change: what an attacker gains who repeats
// datagrams elsewhere, or passes them on before the network does.
#include "tests/sim/story.h"

namespace tims::sim {
namespace stories_sealed_paths {

using Bytes = std::vector<std::byte>;
using link::PathKind;

// A base and a robot that can use both paths.
struct SealedPaths : testing::Test {
  // `announced`: both to each other; otherwise only the base to the robot.
  explicit SealedPaths(bool announced = true, bool sealed = true) {
    if (sealed) network.seal_all();
    const std::string fleet = announced ? "harbour" : "";
    link::LinkSettings below = sub_link();
    link::LinkSettings above = super_link(address_of(0));
    below.paths = above.paths = {PathKind::kUdp, PathKind::kDds};
    base =
        &network.add({.name = "base", .role = core::Role::kTop, .links = {below}, .fleet = fleet});
    robot = &network.add({.name = "robot", .system = 1, .links = {above}, .fleet = fleet});
    network.set_faults({.delay = 1ms});
    base->start(network.now());
    robot->start(network.now());
    if (!announced) {
      robot->links().on_announced(network.now(), base->announcement());
      robot->end_turn(network.now());
    }
    gui = client(*base, kGui);
    ladar = client(*robot, kLadar);
    EXPECT_TRUE(network.run_until([&] { return Story::knows(*base, kLadar); }, 2s));
    network.run_for(3s);  // both paths are known to work
  }
  core::ClientId client(Node& node, Address address) {
    const auto id = node.add_client(network.now(), address.to_string());
    EXPECT_TRUE(node.add_mailbox(network.now(), id, address));
    return id;
  }
  const link::Link& link(Node& node) {
    const link::Link* found = nullptr;
    node.links().for_each([&](const link::Link& one) { found = &one; });
    return *found;
  }
  const link::LinkSessionCounters& at_base() { return link(*base).session().counters(); }
  void report(int count) {
    for (int i = 0; i < count; ++i) {
      ++sent;
      robot->send(network.now(), ladar, {.type = -7, .dest = kGui, .src = kLadar});
      network.run_for(10ms);
    }
  }
  [[nodiscard]] std::size_t arrived() { return base->arrivals(gui).size(); }
  // Keeps the datagrams from the robot to the base over UDP; `hold`: they do not arrive.
  void listen(bool hold) {
    network.tap = [this, hold](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
      if (&from != robot || to != base->address(PathKind::kUdp)) return false;
      heard.emplace_back(bytes.begin(), bytes.end());
      return hold;
    };
  }
  void give(PathKind over) {
    for (const Bytes& bytes : heard)
      network.inject(robot->address(over), base->address(over), bytes);
    network.run_for(1s);
  }
  void expect_no_event() {
    for (Node* node : {base, robot}) {
      EXPECT_EQ(Story::find_event(*node, core::EventKind::kLinkDown), nullptr);
      const core::Event* path = Story::find_event(*node, core::EventKind::kLinkPath);
      EXPECT_EQ(path, nullptr) << node->setup().name << ": " << path->text.view();
    }
  }

  SimulatedNetwork network{1};
  Node* base = nullptr;
  Node* robot = nullptr;
  core::ClientId gui{};
  core::ClientId ladar{};
  std::size_t sent = 0;
  std::vector<Bytes> heard;
};

// What came over UDP comes again over DDS.
TEST_F(SealedPaths, AReplayOverTheOtherPathIsDroppedWithoutAnAnswer) {
  listen(false);
  report(20);
  network.run_for(1s);
  ASSERT_EQ(arrived(), sent);
  const auto replayed = at_base().packets_replayed;
  std::size_t answers = 0;
  std::size_t usual = 0;
  network.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte>) {
    if (&from == base) ++(to == robot->address(PathKind::kDds) ? answers : usual);
    return false;
  };
  network.run_for(1s);
  const std::size_t idle = std::exchange(answers, 0);
  give(PathKind::kDds);
  EXPECT_EQ(arrived(), sent);
  EXPECT_EQ(at_base().packets_replayed, replayed + heard.size());
  EXPECT_LE(answers, idle + 1) << "challenges only, as without the replay";
  expect_no_event();
}

// Held back on one path and given over the other: that is what a path is, and it works once.
TEST_F(SealedPaths, WhatWasHeldBackOnOnePathIsTakenOnceFromTheOther) {
  listen(true);
  report(1);
  ASSERT_FALSE(heard.empty());
  ASSERT_EQ(arrived(), 0U);
  network.tap = {};
  give(PathKind::kDds);
  EXPECT_EQ(arrived(), 1U);
  const auto replayed = at_base().packets_replayed;
  give(PathKind::kUdp);
  give(PathKind::kDds);
  EXPECT_EQ(arrived(), 1U);
  EXPECT_EQ(at_base().packets_replayed, replayed + 2 * heard.size());
  EXPECT_EQ(Story::find_event(*base, core::EventKind::kLinkDown), nullptr);
}

// The copy arrives first, from the attacker's address: it is as good as the original, but the link
// stays where it is, for nobody there can answer a challenge.
TEST_F(SealedPaths, WhoPassesDatagramsOnFirstDoesNotMoveTheLink) {
  const NetAddress attacker = address_of(900);
  std::size_t to_attacker = 0;
  std::size_t passed = 0;
  network.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
    if (to == attacker) to_attacker += bytes.size();
    if (&from == robot && to == base->address(PathKind::kUdp)) {
      passed += bytes.size();
      network.inject(attacker, to, bytes);
    }
    return false;
  };
  for (int i = 0; i < 100; ++i) {
    report(10);
    ASSERT_EQ(link(*base).address(), robot->address(PathKind::kUdp));
  }
  network.run_for(1s);
  EXPECT_EQ(arrived(), sent);
  EXPECT_GT(at_base().packets_replayed, 100U) << "the originals";
  EXPECT_LE(to_attacker, passed / 2);
  expect_no_event();
}

// The base hears the robot over UDP, and the robot hears nothing there. It calls over DDS, where
// the base does not look for it.
struct UnannouncedRobot : SealedPaths, testing::WithParamInterface<bool> {
  UnannouncedRobot() : SealedPaths(false, GetParam()) {}
};
TEST_P(UnannouncedRobot, WhoCallsOverAnotherPathIsReachedThere) {
  network.cut_one_way("base", "robot", true, PathKind::kUdp);
  network.run_for(30s);
  EXPECT_EQ(link(*base).address(), robot->address(PathKind::kDds));
  EXPECT_TRUE(link(*robot).is_up());
  EXPECT_GT(network.now() - link(*robot).since(), 25s);
  EXPECT_EQ(Story::find_event(*base, core::EventKind::kLinkDown), nullptr);
  report(5);
  network.run_for(100ms);
  EXPECT_EQ(arrived(), sent);
}
INSTANTIATE_TEST_SUITE_P(SealedOrOpen, UnannouncedRobot, testing::Bool());

// Handshakes reach the robot, but no data: it calls again every second, and none of the base's
// requests is answered.
TEST_F(SealedPaths, WhoDoesNotHearUsDoesNotViolateTheProtocol) {
  network.tap = [&](Node& from, const NetAddress&, std::span<const std::byte> bytes) {
    return &from == base && bytes.front() == std::byte{1};  // DATA
  };
  network.run_for(30s);
  network.tap = {};
  network.run_for(3s);
  const core::Event* down = Story::find_event(*base, core::EventKind::kLinkDown);
  EXPECT_EQ(down, nullptr) << down->text.view();
  report(5);
  network.run_for(100ms);
  EXPECT_EQ(arrived(), sent);
}

// A NAT that uses two addresses in turns.
TEST_F(SealedPaths, AddressesThatAlternateCostNoMessage) {
  for (std::size_t i = 0; i < 100; ++i) {
    network.move(*robot, address_of(200 + i % 2), 0ms);
    report(20);
  }
  network.run_for(1s);
  EXPECT_EQ(arrived(), sent);
  EXPECT_EQ(Story::find_event(*base, core::EventKind::kLinkDown), nullptr);
  EXPECT_EQ(link(*base).address(), robot->address(PathKind::kUdp));
}

}  // namespace stories_sealed_paths
}  // namespace tims::sim
