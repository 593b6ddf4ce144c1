// Complaints about messages that do not arrive, arrive late, or are lost without a report.
#include <chrono>
#include <cstdio>

#include "tests/sim/story.h"
#include "tests/support/patience.h"

namespace tims::sim {
namespace stories_routes {

TEST(Routes, AFailedLinkIsWithdrawnEverywhere) {
  Story s;
  s.begin();
  s.host->kill();
  EXPECT_TRUE(s.run_until(
      [&] { return !Story::knows(*s.base, kCamera) && !Story::knows(*s.robot, kCamera); },
      3 * kKeepAlive + 50ms));
  s.base->send(s.now(), s.gui, {.type = 3, .dest = kCamera, .src = kGui});
  EXPECT_EQ(Story::not_available(*s.base, s.gui), 1U);
}

TEST(Routes, CommandsToUnknownMailboxesAreAnsweredByTheTop) {
  Story s;
  s.begin();
  s.host->send(s.now(), s.camera, {.type = 3, .dest = Address(0x77010000), .src = kCamera});
  EXPECT_TRUE(s.run_until([&] { return Story::not_available(*s.host, s.camera) == 1; }, 20ms));
  EXPECT_EQ(s.base->router().messages().total(core::Outcome::kNoRoute).messages, 1U);
}

// An operator's joystick for the robot is at the base, and is found from the robot's second host as
// well. A command to a mailbox of the robot that does not exist is answered by the top router,
// once.
TEST(Routes, AMailboxOfARobotMayBeAtTheBase) {
  constexpr Address kJoystick(0x01260000);
  Story s;
  s.begin();
  const auto nowhere = [&] {
    s.host->send(s.now(), s.camera, {.type = 3, .dest = kJoystick, .src = kCamera});
    s.run_for(1s);
    return Story::not_available(*s.host, s.camera);
  };
  EXPECT_EQ(nowhere(), 1U);
  EXPECT_EQ(s.base->router().messages().total(core::Outcome::kNoRoute).messages, 1U);
  const auto joystick = s.client(*s.base, kJoystick);
  EXPECT_TRUE(s.reaches(*s.host, s.camera, kCamera, *s.base, joystick, kJoystick));
  EXPECT_TRUE(s.reaches(*s.robot, s.ladar, kLadar, *s.base, joystick, kJoystick));
  EXPECT_TRUE(s.reaches(*s.base, joystick, kJoystick, *s.host, s.camera, kCamera));
  s.base->remove_client(s.now(), joystick);
  EXPECT_EQ(nowhere(), 2U);
}

TEST(Routes, AnotherSuperRouterTakesOver) {
  SimulatedNetwork w(2);
  Node& a = w.add({.name = "a", .role = core::Role::kTop, .id = 1, .links = {sub_link()}});
  Node& b = w.add({.name = "b", .role = core::Role::kTop, .id = 2, .links = {sub_link()}});
  Node& robot = w.add({.name = "robot",
                       .system = 1,
                       .links = {super_link(address_of(0)), super_link(address_of(1))}});
  for (const auto& node : w.nodes()) node->start(w.now());
  const auto ladar = robot.add_client(w.now(), "ladar");
  robot.add_mailbox(w.now(), ladar, kLadar);
  ASSERT_TRUE(w.run_until([&] { return Story::knows(a, kLadar); }, 2s));
  w.run_for(1s);
  EXPECT_FALSE(Story::knows(b, kLadar));
  w.cut("robot", "a");
  EXPECT_TRUE(w.run_until([&] { return Story::knows(b, kLadar); }, 3 * kKeepAlive + 1s));
  w.run_for(5s);
  EXPECT_FALSE(Story::knows(a, kLadar));
  w.cut("robot", "a", false);
  // A link that has just come up may go down again, so it is used only after some time.
  ASSERT_TRUE(w.run_until([&] { return Story::links_up(robot) == 2; }, 1s));
  w.run_for(400ms);
  EXPECT_EQ(robot.links().uplink()->peer().name.view(), "b");
  EXPECT_TRUE(w.run_until([&] { return Story::knows(a, kLadar) && !Story::knows(b, kLadar); },
                          3 * kKeepAlive + 1s));
}

TEST(Routes, ALinkRemovedFromTheConfigurationIsClosed) {
  Story s;
  s.begin();
  s.robot->links().configure(s.now(), std::vector{sub_link()});
  s.robot->end_turn(s.now());
  s.run_for(100ms);
  EXPECT_EQ(Story::links_up(*s.robot), 1U);
  EXPECT_FALSE(Story::knows(*s.base, kCamera)) << "the base already knows that the host is gone";
  s.robot->links().configure(s.now(), s.robot->setup().links);
  s.robot->links().set_target(s.now(), s.base->address().to_string(), s.base->address());
  s.robot->end_turn(s.now());
  EXPECT_TRUE(s.run_until([&] { return s.converged(); }, 1s));
}

// A robot with two super routers returns to the preferred one without losing messages.
TEST(Routes, NothingIsLostOnReturnToThePreferredSuperRouter) {
  SimulatedNetwork w(3);
  Node& base = w.add({.name = "base", .role = core::Role::kTop, .links = {sub_link()}});
  for (std::uint8_t id = 1; id <= 2; ++id) {
    w.add({.name = "gate" + std::to_string(id),
           .role = core::Role::kSystem,
           .system = 1,
           .id = id,
           .links = {super_link(address_of(0)), sub_link()}});
  }
  Node& robot = w.add({.name = "robot",
                       .role = core::Role::kSubsystem,
                       .system = 1,
                       .id = 3,
                       .links = {super_link(address_of(1)), super_link(address_of(2))}});
  w.set_faults({.delay = 5ms});
  for (const auto& node : w.nodes()) node->start(w.now());
  const auto gui = base.add_client(w.now(), "gui");
  base.add_mailbox(w.now(), gui, kGui);
  const auto ladar = robot.add_client(w.now(), "ladar");
  robot.add_mailbox(w.now(), ladar, kLadar);
  w.cut("robot", "gate1");
  ASSERT_TRUE(w.run_until([&] { return Story::knows(base, kLadar); }, 5s));
  w.run_for(2s);
  w.cut("robot", "gate1", false);
  for (int i = 0; i < 1000; ++i) {
    base.send(w.now(), gui, {.type = 3, .dest = kLadar, .src = kGui});
    robot.send(w.now(), ladar, {.type = 3, .dest = kGui, .src = kLadar});
    w.run_for(5ms);
  }
  w.run_for(100ms);
  EXPECT_EQ(robot.links().uplink()->peer().name.view(), "gate1");
  EXPECT_EQ(robot.arrivals(ladar).size(), 1000U);
  EXPECT_EQ(base.arrivals(gui).size(), 1000U);
}

TEST(Routes, TheTopClassOvertakesLargeMessages) {
  Story s;
  s.begin();
  s.set_faults({.delay = 1ms, .rate = 6'250'000, .queue = 312'500});
  const std::vector<std::byte> image(1 << 20);
  for (int i = 0; i < 8; ++i)
    s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kGui, .src = kLadar}, image);
  s.run_for(500ms);
  const Time sent = s.now();
  s.robot->send(s.now(), s.ladar, {.type = 2, .priority = 255, .dest = kGui, .src = kLadar});
  const auto stop = [](const Arrival& a) { return a.header.priority == 255; };
  ASSERT_TRUE(s.run_until(
      [&] {
        const auto& all = s.base->arrivals(s.gui);
        return std::any_of(all.begin(), all.end(), stop);
      },
      100ms));
  EXPECT_LT(s.now() - sent, 10ms);
  EXPECT_LT(s.base->arrivals(s.gui).size(), 6U);
}

// Urgent messages are marked EF; no data of a robot is marked as background.
TEST(Routes, UrgentDatagramsAreMarked) {
  Story s;
  s.begin();
  for (const auto& [priority, dscp] :
       {std::pair{0, 0}, {1, 0}, {20, 26}, {30, 34}, {40, 46}, {255, 46}}) {
    const auto mark = static_cast<std::uint8_t>(dscp);
    const std::uint64_t before = s.bytes_marked(mark);
    const Header header{
        .type = -7, .priority = static_cast<std::uint8_t>(priority), .dest = kGui, .src = kLadar};
    s.robot->send(s.now(), s.ladar, header, std::vector<std::byte>(10'000));
    s.run_for(100ms);
    EXPECT_GT(s.bytes_marked(mark), before + 10'000) << priority;
  }
}

// Original programs send texts with the priority of their data.
TEST(Routes, TextsAreTheLowestClass) {
  Story s;
  s.begin();
  const std::uint64_t before = s.bytes_marked(8);
  const Header text{.type = -126, .priority = 255, .dest = text_sink(), .src = kLadar};
  for (int i = 0; i < 100; ++i) s.robot->send(s.now(), s.ladar, text, std::vector<std::byte>(100));
  s.run_for(100ms);
  EXPECT_GT(s.bytes_marked(8), before + 10'000);
}

// The robot of the RACK paper sends with priorities 20, 30 and 40: images fill the link, and
// neither scans nor a pilot's commands wait for them.
TEST(Routes, ThePrioritiesOfARobotOvertakeEachOther) {
  Story s;
  s.begin();
  s.set_faults({.delay = 1ms, .rate = 6'250'000, .queue = 312'500});
  const auto send = [&](int priority, std::size_t size) {
    const Header header{
        .type = 2, .priority = static_cast<std::uint8_t>(priority), .dest = kGui, .src = kLadar};
    s.robot->send(s.now(), s.ladar, header, std::vector<std::byte>(size));
  };
  for (const int priority : {19, 29, 39}) {
    for (int i = 0; i < 4; ++i) send(priority, 1 << 20);
    s.run_for(100ms);
    const Time sent = s.now();
    send(priority + 11, 0);
    const auto arrived = [&] {
      return std::ranges::any_of(s.base->arrivals(s.gui), [&](const Arrival& a) {
        return a.header.priority == priority + 11;
      });
    };
    ASSERT_TRUE(s.run_until(arrived, 5s)) << priority;
    EXPECT_LT(s.now() - sent, 10ms) << priority;
    s.run_for(2s);
  }
}

TEST(Routes, SamplesKeepTheLatest) {
  Story s;
  s.begin();
  s.set_faults({.delay = 1ms, .rate = 100'000});
  std::vector<std::byte> scan(3000);
  for (std::uint8_t n = 0; n < 200; ++n) {
    scan[0] = std::byte{n};
    s.robot->send(s.now(), s.ladar,
                  {.flags = flag::kNativeOrder | flag::kStream,
                   .type = type::kData,
                   .seq_nr = n,
                   .dest = kGui,
                   .src = kLadar},
                  scan);
    s.run_for(10ms);  // three times the capacity of the link
  }
  const auto& all = s.base->arrivals(s.gui);
  ASSERT_GT(all.size(), 30U);
  EXPECT_LT(all.size(), 100U);
  // The newest sample is not older than the contents of the window.
  EXPECT_GE(all.back().header.seq_nr, 185);
  EXPECT_GT(s.robot->router().messages().total(core::Outcome::kQueueReplaced).messages, 50U);
}

TEST(Routes, ANewMailboxIsKnownAtTheTopImmediately) {
  Story s;
  s.begin();
  s.set_faults({.delay = 10ms});
  s.run_for(1s);
  const auto client = s.host->add_client(s.now(), "new");
  s.host->add_mailbox(s.now(), client, Address(0x01170000));
  // Two links.
  EXPECT_TRUE(s.run_until([&] { return Story::knows(*s.base, Address(0x01170000)); }, 21ms));
}

// A top router above a thousand routers with a hundred mailboxes each.
TEST(Routes, AThousandRoutersComeBack) {
  SimulatedNetwork w(4);
  constexpr std::uint32_t kRouters = test::kSlowdown > 1 ? 100 : 1000;
  constexpr std::uint32_t kMailboxes = 100;
  Node& top = w.add({.name = "top", .role = core::Role::kTop, .links = {sub_link()}});
  for (std::uint32_t i = 0; i < kRouters; ++i) {
    // Four routers share a system number and differ in their router id.
    w.add({.name = "r" + std::to_string(i),
           .system = static_cast<std::uint8_t>(i / 4 + 1),
           .id = static_cast<std::uint8_t>(i % 4 + 1),
           .links = {super_link(address_of(0))},
           .block_bytes = 1U << 20,
           .message_bytes = 1U << 20});
  }
  w.set_faults({.delay = 1ms});
  for (std::uint32_t i = 0; i <= kRouters; ++i) {
    Node& node = *w.nodes()[i];
    node.start(w.now());
    if (i == 0) continue;
    const auto client = node.add_client(w.now(), "c");
    for (std::uint32_t m = 0; m < kMailboxes; ++m)
      node.add_mailbox(
          w.now(), client,
          Address::of(
              {.system = node.setup().system, .class_id = 0x20U + node.setup().id, .local = m}));
  }
  const std::size_t all = kRouters * (kMailboxes + 1);
  ASSERT_TRUE(w.run_until([&] { return top.router().table().size() == all; }, 5s));
  top.kill();
  w.run_for(100ms);
  top.start(w.now());
  const Time start = w.now();
  const auto real = std::chrono::steady_clock::now();
  EXPECT_TRUE(w.run_until([&] { return top.router().table().size() == all; }, 2s));
  std::printf("%zu mailboxes known again after %.0f ms, in %.2f s of this machine\n",
              top.router().table().size(),
              std::chrono::duration<double, std::milli>(w.now() - start).count(),
              std::chrono::duration<double>(std::chrono::steady_clock::now() - real).count());
}

}  // namespace stories_routes
}  // namespace tims::sim
