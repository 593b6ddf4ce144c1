// A router that is restarted for an upgrade leaves its links to the next one: nothing reliable is
// lost, doubled or out of order, and nobody else notices.
#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include <gmock/gmock.h>

#include "router/link/handover.h"
#include "tests/sim/restart_storm.h"
#include "tests/sim/story.h"
#include "tests/support/patience.h"

namespace tims::sim {
namespace stories_restart {

struct Restart : Story {
  explicit Restart(bool sealed, std::uint64_t seed = 1)
      : Story(seed, {}, core::Compression::kOff, sealed) {
    begin();
  }
  core::ClientId& client_of(Node& node) {
    if (&node == base) return gui;
    return &node == robot ? ladar : camera;
  }
  static Address mailbox_of(const Node& node) {
    if (node.setup().name == "base") return kGui;
    return node.setup().name == "robot" ? kLadar : kCamera;
  }
  void restart(Node& node, Duration without = 30ms) {
    away = &node;
    const auto state = node.hand_over(now());
    run_for(without);
    const auto restored = node.start(now(), state);
    ASSERT_TRUE(restored) << node.setup().name;
    EXPECT_EQ(*restored, &node == host ? 1U : 2U) << node.setup().name;
    run_for(10ms);
    client_of(node) = client(node, mailbox_of(node));
    away = nullptr;
  }
  [[nodiscard]] static bool is_up(Node& at, std::string_view peer) {
    bool up = false;
    at.links().for_each(
        [&](const link::Link& link) { up |= link.is_up() && link.peer().name.view() == peer; });
    return up;
  }
  [[nodiscard]] std::size_t downs() const {
    std::size_t downs = 0;
    for (const auto& node : {base, robot, host, other})
      for (const core::Event& event : node->events)
        downs +=
            event.kind == core::EventKind::kWithdrawn || event.kind == core::EventKind::kLinkDown;
    return downs;
  }

  const Node* away = nullptr;  // its clients have no router
};

// Between the GUI at the base and the camera below two links, in both directions, every 5 ms: small
// ones and ones of many datagrams, of several classes.
class Traffic {
 public:
  explicit Traffic(Restart& story) : story_(story) {
    for (Node* node : {story_.base, story_.host})
      node->on_arrival = [this](Node& at, core::ClientId, Arrival&& arrival) {
        take(at, std::move(arrival));
      };
    tick();
  }
  void stop() { stopped_ = true; }
  [[nodiscard]] bool all_arrived() const { return arrived_ == sent_; }
  [[nodiscard]] std::string text() const {
    return std::to_string(arrived_) + " of " + std::to_string(sent_);
  }
  [[nodiscard]] std::uint64_t sent() const { return sent_; }

 private:
  static constexpr std::array<std::uint8_t, 3> kPriorities{5, 20, 110};

  void tick() {
    if (stopped_) return;
    if (story_.away != story_.base) send(*story_.base, story_.gui, kGui, kCamera);
    if (story_.away != story_.host) send(*story_.host, story_.camera, kCamera, kGui);
    ++number_;
    story_.at(story_.now() + 5ms, [this] { tick(); });
  }
  // A program whose router is away is told so: it sends nothing here.
  void send(Node& from, core::ClientId client, Address src, Address dest) {
    const std::uint8_t priority = kPriorities[number_ % kPriorities.size()];
    const std::uint32_t next = ++next_[{src.raw(), priority}];
    std::vector<std::byte> body(number_ % 7 == 0 ? 100'000 : 40);
    std::memcpy(body.data(), &next, sizeof next);
    const core::Outcome outcome = from.send(
        story_.now(), client, {.type = -7, .priority = priority, .dest = dest, .src = src}, body);
    ASSERT_EQ(outcome, core::Outcome::kDelivered) << story_.now().time_since_epoch().count();
    ++sent_;
  }
  void take(Node& at, Arrival&& arrival) {
    if (arrival.header.type != -7) return;
    std::uint32_t number = 0;
    std::memcpy(&number, arrival.body.data(), sizeof number);
    const auto flow = std::pair(arrival.header.src.raw(), arrival.header.priority);
    EXPECT_EQ(number, last_[flow] + 1)
        << "at " << at.setup().name << " of priority " << int{arrival.header.priority};
    last_[flow] = number;
    ++arrived_;
  }

  using Flow = std::pair<std::uint32_t, std::uint8_t>;
  Restart& story_;
  std::map<Flow, std::uint32_t> next_;
  std::map<Flow, std::uint32_t> last_;
  std::uint64_t number_ = 0;
  std::uint64_t sent_ = 0;
  std::uint64_t arrived_ = 0;
  bool stopped_ = false;
};

class EachRouter : public testing::TestWithParam<std::tuple<bool, std::string>> {};

TEST_P(EachRouter, LosesNothingAndNobodyNotices) {
  const auto& [sealed, which] = GetParam();
  Restart s(sealed);
  Node& node = s.node(which);
  Traffic traffic(s);
  s.run_for(200ms);
  const std::size_t before = s.downs();
  for (int i = 0; i < 10; ++i) {
    s.restart(node);
    for (int ms = 0; ms < 100; ++ms) {
      s.run_for(1ms);
      EXPECT_TRUE(s.converged());
    }
  }
  traffic.stop();
  EXPECT_TRUE(s.run_until([&] { return traffic.all_arrived(); }, 3s)) << traffic.text();
  EXPECT_EQ(s.downs(), before) << "a link or a mailbox was withdrawn";
  EXPECT_GT(traffic.sent(), 400U);
}

INSTANTIATE_TEST_SUITE_P(Upgrade, EachRouter,
                         testing::Combine(testing::Bool(),
                                          testing::Values("base", "robot", "host")));

// On a bad line, and all of them one after the other.
TEST(Upgrade, LosesNothingOnABadLine) {
  for (const bool sealed : {false, true}) {
    Restart s(sealed, 7);
    s.set_faults({.loss = 0.05, .delay = 3ms, .jitter = 2ms});
    Traffic traffic(s);
    for (int i = 0; i < 5; ++i)
      for (Node* node : {s.base, s.robot, s.host}) {
        s.run_for(400ms);
        s.restart(*node);
      }
    traffic.stop();
    EXPECT_TRUE(s.run_until([&] { return traffic.all_arrived(); }, 10s)) << traffic.text();
  }
}

// Messages of programs wait in the links until those pass datagrams again.
TEST(Upgrade, MessagesSentBeforeTheLinksGoOnArrive) {
  Restart s(true);
  const Address late(0x01170000);
  ASSERT_TRUE(s.host->add_mailbox(s.now(), s.camera, late));
  const auto state = s.host->hand_over(s.now());
  ASSERT_TRUE(s.host->start(s.now(), state));
  s.camera = s.client(*s.host, kCamera);
  s.host->send(s.now(), s.camera, {.type = -7, .dest = kGui, .src = kCamera});
  s.run_for(10ms);
  EXPECT_TRUE(s.base->arrivals(s.gui).empty());
  ASSERT_TRUE(s.host->add_mailbox(s.now(), s.camera, late));
  EXPECT_TRUE(s.run_until([&] { return !s.base->arrivals(s.gui).empty(); }, 100ms));
}

// A router that is restarted again before its programs are back passes on what it got: nothing is
// withdrawn meanwhile, and the programs are waited for again.
TEST(Upgrade, ARestartWhileProgramsAreAwaitedPassesEverythingOn) {
  for (const bool sealed : {false, true}) {
    Restart s(sealed);
    s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kCamera, .src = kLadar});
    const std::size_t before = s.downs();
    auto state = s.host->hand_over(s.now());
    for (int i = 0; i < 10; ++i) {
      s.run_for(10ms);
      ASSERT_EQ(s.host->start(s.now(), state), 1U);
      s.run_for(10ms);
      state = s.host->hand_over(s.now());
    }
    ASSERT_EQ(s.host->start(s.now(), state), 1U);
    s.camera = s.client(*s.host, kCamera);
    EXPECT_TRUE(s.run_until([&] { return !s.host->arrivals(s.camera).empty(); }, 100ms));
    EXPECT_TRUE(s.gui_reaches_camera());
    EXPECT_EQ(s.downs(), before) << "a link or a mailbox was withdrawn";
  }
}

// The other router knows of the first restart, so it believes another cookie soon.
TEST(Upgrade, ARestartDuringAHandshakeDelaysNothing) {
  Restart s(true);
  bool shakes_hands = false;
  s.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
    shakes_hands |= &from == s.robot && to == s.base->address() && bytes[0] == std::byte{7};
    return false;
  };
  s.restart(*s.base, 5ms);
  ASSERT_TRUE(s.run_until([&] { return shakes_hands; }, 1s));
  s.restart(*s.base, 5ms);
  EXPECT_TRUE(s.reaches(*s.base, s.gui, kGui, *s.host, s.camera, kCamera, 400ms));
}

// The calling side has its keys, and the other side has received nothing sealed by them.
TEST(Upgrade, ARestartBeforeALinkIsUpOnBothSidesDelaysNothing) {
  Restart s(true);
  s.robot->kill();
  s.robot->start(s.now());
  s.ladar = s.client(*s.robot, kLadar);
  ASSERT_TRUE(s.run_until([&] { return s.is_up(*s.robot, "base"); }, 3s));
  ASSERT_FALSE(s.is_up(*s.base, "robot"));
  s.robot->events.clear();
  s.restart(*s.base, 5ms);
  EXPECT_TRUE(s.run_until([&] { return Story::knows(*s.base, kLadar); }, 400ms));
  EXPECT_TRUE(s.reaches(*s.base, s.gui, kGui, *s.robot, s.ladar, kLadar, 100ms));
  s.run_for(2s);
  EXPECT_EQ(Story::find_event(*s.robot, core::EventKind::kLinkDown), nullptr);
}

// The address of the other router is the last one known.
TEST(Upgrade, ALinkThatIsSilentGoesOn) {
  for (const bool sealed : {false, true}) {
    Restart s(sealed);
    s.cut("base", "robot");
    ASSERT_TRUE(s.run_until([&] { return !s.is_up(*s.base, "robot"); }, 3s));
    s.restart(*s.base);
    s.cut("base", "robot", false);
    ASSERT_TRUE(s.run_until([&] { return s.is_up(*s.base, "robot"); }, 1s));
    const std::size_t before = s.downs();
    EXPECT_TRUE(s.run_until([&] { return s.gui_reaches_camera(); }, 1s));
    s.run_for(2s);
    EXPECT_EQ(s.downs(), before) << "a link or a mailbox was withdrawn";
  }
}

// A mailbox whose program has not come back is withdrawn at once, the others are not.
TEST(Upgrade, WhoDoesNotComeBackIsWithdrawn) {
  Restart s(false);
  const Address gone(0x01170000);
  ASSERT_TRUE(s.host->add_mailbox(s.now(), s.camera, gone));
  ASSERT_TRUE(s.run_until([&] { return Story::knows(*s.base, gone); }, 1s));
  s.restart(*s.host);
  s.run_for(link::Links::kReturnTime - 20ms);
  EXPECT_TRUE(Story::knows(*s.base, gone));
  EXPECT_TRUE(s.run_until([&] { return !Story::knows(*s.base, gone); }, 100ms));
  EXPECT_TRUE(s.converged());
  s.run_for(3s);
  EXPECT_TRUE(s.converged());
  EXPECT_TRUE(s.gui_reaches_camera());
}

// On a busy machine: longer than the silence after which a link is believed to be down.
TEST(Upgrade, ASlowRestartIsNotNoticedEither) {
  for (const bool sealed : {false, true}) {
    Restart s(sealed);
    const std::size_t before = s.downs();
    s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kCamera, .src = kLadar});
    s.restart(*s.robot, 4500ms);
    EXPECT_TRUE(s.run_until([&] { return s.gui_reaches_camera(); }, 1s));
    EXPECT_EQ(s.host->arrivals(s.camera).size(), 2U);
    EXPECT_EQ(s.downs(), before) << "a link or a mailbox was withdrawn";
  }
}

// The router that has lost its keys cannot open what announces the restart of the other one.
TEST(Upgrade, ASlowRestartThatFollowsAnotherIsNotNoticedEither) {
  Restart s(true);
  const std::size_t before = s.downs();
  const auto state = s.base->hand_over(s.now());
  ASSERT_EQ(s.base->start(s.now(), state), 2U);
  s.gui = s.client(*s.base, kGui);
  s.restart(*s.robot, 4500ms);
  EXPECT_TRUE(s.run_until([&] { return s.gui_reaches_camera(); }, 1s));
  EXPECT_EQ(s.downs(), before) << "a link or a mailbox was withdrawn";
}

// A router that is silent for no reason, after its restart as before it.
TEST(Upgrade, PatienceEnds) {
  Restart s(false);
  s.restart(*s.robot);
  s.run_for(5s);
  s.robot->kill();
  EXPECT_TRUE(s.run_until([&] { return !Story::knows(*s.base, kLadar); }, 1s));
}

// The same for one that was waited for because its restart could not have been heard of.
TEST(Upgrade, PatienceEndsWithTheNextHandshake) {
  Restart s(true);
  s.restart(*s.base);
  ASSERT_TRUE(s.gui_reaches_camera());
  s.robot->kill();
  EXPECT_TRUE(s.run_until([&] { return !Story::knows(*s.base, kLadar); }, 1s));
}

// Longer than the others wait for it.
TEST(Upgrade, AfterALongPauseTheSessionsGoOnToo) {
  for (const bool sealed : {false, true}) {
    Restart s(sealed);
    s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kCamera, .src = kLadar});
    s.restart(*s.robot, 9s);
    EXPECT_TRUE(s.run_until([&] { return s.converged(); }, 3s));
    EXPECT_TRUE(s.gui_reaches_camera());
    EXPECT_EQ(s.host->arrivals(s.camera).size(), 2U);
  }
}

TEST(Upgrade, AnotherLayoutIsAPlainRestart) {
  Restart s(false);
  const auto state = s.robot->hand_over(s.now());
  auto newer = state;
  newer[8] = static_cast<std::byte>(link::Handover::kVersion + 1);
  EXPECT_FALSE(s.robot->start(s.now(), newer));
  s.ladar = s.client(*s.robot, kLadar);
  EXPECT_TRUE(s.run_until([&] { return s.converged(); }, 3s));
  EXPECT_TRUE(s.gui_reaches_camera());
}

// While a fleet is upgraded: an earlier router does not say what it can decompress, and a later one
// says more at the end.
TEST(Upgrade, RoutersOfTwoVersionsUnderstandEachOther) {
  for (const bool is_later : {false, true}) {
    Story s(1, {}, core::Compression::kLz4);
    s.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> sent) {
      std::vector<std::byte> bytes(sent.begin(), sent.end());
      const auto datagram = link::decode(bytes);
      if (&from != s.robot || !datagram) return false;
      if (const auto* hello = std::get_if<link::Hello>(&*datagram)) {
        link::Hello other = *hello;
        other.codecs = is_later ? hello->codecs : 0;
        (void)link::encode(other, bytes);
        if (is_later) std::ranges::fill(std::span(bytes).last(32), std::byte{0xEE});
      } else if (std::holds_alternative<link::Welcome>(*datagram)) {
        is_later ? bytes.resize(bytes.size() + 32, std::byte{0xEE}) : bytes.pop_back();
      } else {
        return false;
      }
      s.inject(from.address(), to, bytes);
      return true;
    };
    s.begin();
    EXPECT_TRUE(s.gui_reaches_camera());
    for (Node* node : {s.base, s.host})
      node->links().for_each([&](const link::Link& link) {
        if (link.peer().name.view() != "robot") return;
        EXPECT_EQ(link.packs_with().has_value(), is_later) << node->setup().name;
      });
  }
}

// What is right by its checksum may still be wrong.
TEST(Upgrade, WrongContentsDoNotKeepARouterFromStarting) {
  Restart s(false);
  Traffic traffic(s);
  s.run_for(101ms);
  traffic.stop();
  const auto state = s.robot->hand_over(s.now());
  auto former = link::Handover::decode(s.now(), state);
  ASSERT_TRUE(former.ok());
  for (std::size_t at = 0; at < former->links.size(); at += 11) {
    link::Handover wrong = *former;
    wrong.at = s.now();
    wrong.mailboxes.clear();  // it waits for nobody
    wrong.links[at] ^= std::byte{0xFF};
    ASSERT_TRUE(s.robot->start(s.now(), wrong.encode()));
    s.robot->kill();
  }
  s.robot->start(s.now());
  s.ladar = s.client(*s.robot, kLadar);
  EXPECT_TRUE(s.run_until([&] { return s.converged(); }, 5s));
}

TEST(Upgrade, NothingIsLostHoweverOftenRoutersAreRestarted) {
  for (std::uint64_t seed = 1; seed <= test::rounds(60); ++seed)
    for (const std::string& failure : RestartStorm(seed, false).run())
      ADD_FAILURE() << failure << "\n  build/release/tests/sim_swarm --storms --seed " << seed
                    << " --verbose";
}

}  // namespace stories_restart
}  // namespace tims::sim
