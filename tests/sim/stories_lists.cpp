// Lists of the fleet on their way: a certificate is revoked at one router, and all others know.
#include "tests/sim/story.h"

namespace tims::sim {
namespace stories_lists {

struct Three : Story {
  Three() : Story(3, {}, core::Compression::kOff, true) {}
  void renew(Node& node, std::uint8_t root) {
    ToyKeys keys = *node.setup().keys;
    keys.root = root;
    node.renew(now(), keys);
  }
  void publish(Node& node, const ToyList& list) {
    node.put_list(now(), list.encode(node.setup().keys->fleet));
  }
  bool all_have(std::uint64_t number, Duration within) {
    const auto has = [&](const Node* node) { return node->list_number() == number; };
    return run_until(
        [&] {
          return std::ranges::all_of(std::array{base, robot, host, other}, has);
        },
        within);
  }
  static std::size_t ups(const Node& node) {
    return static_cast<std::size_t>(std::ranges::count_if(
        node.events, [](const core::Event& e) { return e.kind == core::EventKind::kLinkUp; }));
  }
};

TEST(Lists, GoThroughThreeLevelsWithinASecond) {
  Three s;
  s.begin();
  s.publish(*s.base, {.number = 2});
  EXPECT_TRUE(s.all_have(2, 300ms));
  s.publish(*s.host, {.number = 3});
  EXPECT_TRUE(s.all_have(3, 300ms)) << "also upwards";
  EXPECT_EQ(s.host->lists_checked(), 1U) << "nobody is sent what it has";
  EXPECT_TRUE(s.gui_reaches_camera());
}

TEST(Lists, EndTheLinkOfWhoIsRevoked) {
  Three s;
  s.begin();
  // At the lowest router; the base, two levels above it, has the link.
  s.publish(*s.host, {.number = 2, .revoked = {{2, 1}}});
  ASSERT_TRUE(s.run_until([&] { return !Story::knows(*s.base, kChassis); }, 1s));
  const core::Event* down = Story::find_event(*s.base, core::EventKind::kLinkDown);
  ASSERT_NE(down, nullptr);
  EXPECT_EQ(down->reason, core::CloseReason::kRevoked);
  EXPECT_EQ(core::sentence(down->reason), "its certificate is revoked");
  EXPECT_TRUE(s.gui_reaches_camera()) << "the others stay";
}

const core::Event* link_down(const Node& node, const std::string& name) {
  for (const core::Event& event : node.events)
    if (event.kind == core::EventKind::kLinkDown && event.client.name.view() == name) return &event;
  return nullptr;
}

// All have renewed; the base, which is called by all, shows its new certificate in no handshake
// before the list comes.
TEST(Lists, TheEndOfARootCutsNobodyWhoHasRenewed) {
  Three s;
  s.begin();
  for (Node* node : {s.host, s.robot, s.other, s.base}) {
    s.renew(*node, 2);
    s.run_for(100ms);
  }
  s.publish(*s.base, {.number = 2, .first_root = 2});
  EXPECT_TRUE(s.all_have(2, 1s));
  s.run_for(20s);
  for (Node* node : {s.host, s.robot, s.other, s.base})
    EXPECT_EQ(Story::find_event(*node, core::EventKind::kLinkDown), nullptr) << node->setup().name;
  EXPECT_TRUE(s.gui_reaches_camera());
}

// A router that was called is cut off at once, one that calls has the time of a handshake.
TEST(Lists, TheEndOfARootEndsLinksOfItsCertificates) {
  Three s;
  s.begin();
  for (Node* node : {s.host, s.robot}) s.renew(*node, 2);  // neither the base nor `other`
  s.run_for(100ms);
  s.publish(*s.base, {.number = 2, .first_root = 2});
  ASSERT_TRUE(s.run_until([&] { return !Story::knows(*s.base, kChassis); }, 100ms));
  const core::Event* down = link_down(*s.base, "other");
  ASSERT_NE(down, nullptr);
  EXPECT_EQ(core::sentence(down->reason),
            "its certificate comes from a root that the fleet believes no longer");
  EXPECT_EQ(link_down(*s.base, "robot"), nullptr);
  const Time end = s.now() + 10s;
  s.run_for(9s);
  EXPECT_EQ(link_down(*s.robot, "base"), nullptr);
  ASSERT_TRUE(s.run_until([&] { return link_down(*s.robot, "base") != nullptr; }, 2s));
  EXPECT_EQ(link_down(*s.robot, "base")->reason, core::CloseReason::kOldRoot);
  EXPECT_LE(s.now(), end + 100ms);
  s.run_for(20s);
  EXPECT_EQ(Story::links_up(*s.other), 0U);
  EXPECT_EQ(Story::links_up(*s.host), 1U) << "the robot and its host have renewed";
}

// However far a handshake has come when the list arrives: it does not bring who is revoked in.
TEST(Lists, HoldForHandshakesThatHadBegun) {
  std::size_t in_time = 0;
  for (Duration after = 0ms; after < 12ms; after += 800us) {
    Three s;
    for (Node* node : {s.base, s.robot, s.host}) node->start(s.now());
    s.run_for(1s);
    s.other->start(s.now());
    s.run_for(after);
    in_time += s.base->handshakes() > 0 && Story::links_up(*s.base) == 1 ? 1 : 0;
    s.publish(*s.base, {.number = 2, .revoked = {{2, 1}}});
    s.run_for(3s);
    EXPECT_EQ(Story::links_up(*s.base), 1U) << "list after " << after.count() << " ns";
  }
  EXPECT_GE(in_time, 3U) << "while a handshake was in progress";
}

// The others go on as they are: no new handshake for the sake of somebody else's certificate.
TEST(Lists, LeaveTheOtherLinksAlone) {
  Three s;
  s.begin();
  const auto ups = Three::ups(*s.robot);
  std::size_t handshakes = 0;
  s.tap = [&](Node&, const NetAddress&, std::span<const std::byte> datagram) {
    handshakes += datagram[0] == std::byte{2} || datagram[0] == std::byte{7} ? 1 : 0;
    return false;
  };
  s.publish(*s.base, {.number = 2});
  EXPECT_TRUE(s.all_have(2, 1s));
  s.run_for(5s);
  EXPECT_EQ(handshakes, 0U);
  EXPECT_EQ(Three::ups(*s.robot), ups);
}

TEST(Lists, OfAMegabyteAndOverABadNetwork) {
  Three s;
  s.begin();
  s.set_faults({.loss = 0.2, .delay = 5ms, .jitter = 5ms});
  s.publish(*s.base, {.number = 2, .size = link::ListExchange::kBytesMax});
  EXPECT_TRUE(s.all_have(2, 60s));
  s.set_faults({.delay = 1ms});
  s.run_for(5s);
  s.publish(*s.base, {.number = 3, .size = link::ListExchange::kBytesMax});
  EXPECT_TRUE(s.all_have(3, 2s));
}

// Who was away learns it at the first contact, whichever side has it.
TEST(Lists, ReachWhoWasAway) {
  Three s;
  s.begin();
  s.cut("robot", "base");
  s.run_for(2s);
  s.publish(*s.host, {.number = 2});
  s.run_for(1s);
  EXPECT_EQ(s.base->list_number(), 0U);
  s.set_faults("robot", "base", {.delay = 1ms});
  s.set_faults("base", "robot", {.delay = 1ms});
  EXPECT_TRUE(s.all_have(2, 3s));
  s.other->kill();
  s.publish(*s.base, {.number = 3});
  s.run_for(1s);
  s.other->start(s.now());
  EXPECT_TRUE(s.all_have(3, 3s));
}

TEST(Lists, NeverGoBack) {
  Three s;
  s.begin();
  s.publish(*s.base, {.number = 5});
  ASSERT_TRUE(s.all_have(5, 1s));
  const std::size_t checked = s.robot->lists_checked();
  s.host->kill();
  s.publish(*s.host, {.number = 4});  // an old backup of its disk
  s.host->start(s.now());
  EXPECT_TRUE(s.all_have(5, 3s));
  EXPECT_EQ(s.robot->lists_checked(), checked) << "an older one is not even fetched";
}

TEST(Lists, TwoAtOnce) {
  Three s;
  s.begin();
  s.publish(*s.base, {.number = 2, .size = 100'000});
  s.publish(*s.host, {.number = 3, .size = 100'000});
  EXPECT_TRUE(s.all_have(3, 1s));
}

// A router in the hands of an attacker offers what the authority has not signed.
TEST(Lists, ForgedOnesAreRefusedAndTheirSenderIsLeftAlone) {
  Three s;
  s.begin();
  s.host->put_list(s.now(), ToyList{.number = 9, .revoked = {{0, 1}}}.encode(4711));
  s.run_for(10s);
  EXPECT_EQ(s.robot->list_number(), 0U);
  EXPECT_EQ(s.robot->lists_checked(), 1U) << "once a minute";
  EXPECT_EQ(s.base->lists_checked(), 0U);
  EXPECT_TRUE(s.gui_reaches_camera());
  s.publish(*s.base, {.number = 2});
  EXPECT_TRUE(
      s.run_until([&] { return s.robot->list_number() == 2 && s.other->list_number() == 2; }, 1s))
      << "it does not delay the right ones";
  s.run_for(60s);
  EXPECT_EQ(s.robot->lists_checked(), 3U);
}

// A copied SD card: both robots show one certificate.
TEST(Clones, AreNamedWithBothAddresses) {
  Three s;
  s.begin();
  Node& copy = s.add({.name = "robot",
                      .role = core::Role::kSystem,
                      .system = 1,
                      .links = {super_link(s.base->address())}});
  copy.start(s.now());
  s.run_for(5s);
  EXPECT_EQ(Story::links_up(copy), 0U);
  const core::Event* refused = Story::find_event(copy, core::EventKind::kLinkRefused);
  ASSERT_NE(refused, nullptr);
  EXPECT_NE(refused->text.view().find("with this certificate: a copied disk? timsctl token new"),
            std::string_view::npos)
      << refused->text.view();
  const core::Event* named = Story::find_event(*s.base, core::EventKind::kDuplicateRouter);
  ASSERT_NE(named, nullptr);
  EXPECT_EQ(named->client.endpoint.view(), copy.address().to_string());
  EXPECT_EQ(named->owner.endpoint.view(), s.robot->address().to_string());
  EXPECT_TRUE(s.gui_reaches_camera()) << "the first one stays";
}

}  // namespace stories_lists
}  // namespace tims::sim
