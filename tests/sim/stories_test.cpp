// Single stories, each as short as it can be told.
#include <gtest/gtest.h>

#include "tests/sim/world.h"

namespace tims::sim {
namespace {

using namespace std::chrono_literals;
constexpr Address kLadar{0x01140000};

// A base above a robot of one host.
struct Pair : World {
  explicit Pair(std::uint64_t seed) : World(seed) {
    base = &add({.name = "base", .role = core::Role::kTop, .links = {sub_link()}});
    robot = &add({.name = "robot", .system = 1, .links = {super_link(address_of(0))}});
    base->start(now());
    robot->start(now());
  }
  bool knows(Node& node, Address address) { return node.router().find(address) != nullptr; }
  Node* base;
  Node* robot;
};

TEST(Story, ALinkComesUpAndTheTopKnowsTheMailboxes) {
  Pair world(1);
  const auto client = world.robot->add_client(world.now(), "ladar");
  ASSERT_TRUE(world.robot->add_mailbox(world.now(), client, kLadar));
  EXPECT_TRUE(world.run_until([&] { return world.knows(*world.base, kLadar); }, 1s));
  EXPECT_NE(world.robot->router().uplink(), core::kNoClient);
}

TEST(Story, AMessageGoesUpAndItsAnswerComesDown) {
  Pair world(2);
  const auto ladar = world.robot->add_client(world.now(), "ladar");
  ASSERT_TRUE(world.robot->add_mailbox(world.now(), ladar, kLadar));
  const auto gui = world.base->add_client(world.now(), "gui");
  const Address kGui(0x00020000);
  ASSERT_TRUE(world.base->add_mailbox(world.now(), gui, kGui));
  ASSERT_TRUE(world.run_until([&] { return world.knows(*world.base, kLadar); }, 1s));
  EXPECT_EQ(world.base->send(world.now(), gui, {.type = 3, .dest = kLadar, .src = kGui}),
            core::Outcome::kDelivered);
  ASSERT_TRUE(world.run_until([&] { return world.robot->arrivals(ladar).size() == 1; }, 1s));
  EXPECT_EQ(world.robot->send(world.now(), ladar, {.type = -4, .dest = kGui, .src = kLadar}),
            core::Outcome::kDelivered);
  ASSERT_TRUE(world.run_until([&] { return world.base->arrivals(gui).size() == 1; }, 1s));
}

}  // namespace
}  // namespace tims::sim
