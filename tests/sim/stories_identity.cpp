// Complaints about loops, duplicate identities and unknown senders.
#include "router/link/datagram.h"
#include "tests/sim/story.h"

namespace tims::sim {
namespace stories_identity {

TEST(Identity, TwoRunningRoutersHaveOneId) {
  Story s;
  s.begin();
  Node& clone = s.add({.name = "clone",
                       .role = core::Role::kSystem,
                       .system = 1,
                       .links = {super_link(address_of(0))}});
  clone.start(s.now());
  s.run_for(5s);
  EXPECT_EQ(Story::links_up(clone), 0U);
  EXPECT_EQ(Story::links_up(*s.robot), 2U);
  const core::Event* event = Story::find_event(*s.base, core::EventKind::kDuplicateRouter);
  ASSERT_NE(event, nullptr);
  EXPECT_EQ(event->client.name.view(), "clone");
  EXPECT_EQ(event->owner.name.view(), "robot");
  const core::Event* refused = Story::find_event(clone, core::EventKind::kLinkRefused);
  ASSERT_NE(refused, nullptr);
  EXPECT_NE(refused->text.view().find("robot"), std::string_view::npos);
}

// The first router has a long keep-alive interval.
TEST(Identity, TheFirstOfTwoKeepsItsLinkForItsOwnKeepAlive) {
  SimulatedNetwork w(9);
  auto seldom = super_link(address_of(0));
  seldom.keep_alive = 2s;
  Node& base = w.add({.name = "base", .role = core::Role::kTop, .links = {sub_link()}});
  Node& robot = w.add({.name = "robot", .system = 1, .links = {seldom}});
  Node& clone = w.add({.name = "clone", .system = 1, .links = {super_link(address_of(0))}});
  base.start(w.now());
  robot.start(w.now());
  w.run_for(1s);
  clone.start(w.now());
  w.run_for(20s);
  EXPECT_EQ(Story::links_up(clone), 0U);
  EXPECT_EQ(Story::links_up(robot), 1U);
  EXPECT_EQ(Story::find_event(base, core::EventKind::kLinkDown), nullptr);
}

TEST(Identity, ARefusedRouterReceivesTheReason) {
  Story s;
  s.begin();
  Node& choosy = s.add({.name = "choosy", .role = core::Role::kTop, .links = {sub_link(4)}});
  choosy.start(s.now());
  const auto why_not = [&](const NodeSetup& setup) {
    Node& node = s.add(setup);
    node.start(s.now());
    s.run_for(500ms);
    EXPECT_EQ(Story::links_up(node), 0U);
    const core::Event* refused = Story::find_event(node, core::EventKind::kLinkRefused);
    return refused == nullptr ? std::string() : std::string(refused->text.view());
  };
  EXPECT_EQ(why_not({.name = "twin",
                     .role = core::Role::kSubsystem,
                     .system = 1,
                     .links = {super_link(s.robot->address())}}),
            "Tims(1/1) robot already has this system and id: choose another [router] id");
  EXPECT_EQ(why_not({.name = "self",
                     .system = 3,
                     .links = {peer_link(address_of(s.nodes().size())),
                               {.kind = core::LinkKind::kPeer, .connects = false}}}),
            "this is the router itself");
  EXPECT_EQ(
      why_not({.name = "low",
               .role = core::Role::kSubsystem,
               .system = 3,
               .links = {super_link(s.base->address())}}),
      "Tims(0/1) base is a top router, which cannot be a super router for a subsystem router");
  EXPECT_EQ(why_not({.name = "five", .system = 5, .links = {super_link(choosy.address())}}),
            "Tims(0/1) choosy accepts system 4, not 5");
  EXPECT_EQ(why_not({.name = "beside", .system = 6, .links = {peer_link(choosy.address())}}),
            "Tims(0/1) choosy is a top router, which cannot be a peer router for a system router");
}

// The link is reset while the network is down; after that the router has another address.
TEST(Identity, ARouterIsNotItsOwnDuplicate) {
  Story s;
  s.begin();
  s.cut("robot", "base");
  s.robot->links().act(s.now(), "base", link::Links::Action::kReset);
  s.robot->end_turn(s.now());
  s.move(*s.robot, address_of(500), 0ms);
  EXPECT_TRUE(s.run_until([&] { return Story::links_up(*s.robot) == 2; }, kKeepAlive + 50ms));
}

TEST(Identity, TwoMailboxesHaveOneAddress) {
  constexpr Address kTwice{0x01100000};
  Story s;
  Node& second_host = s.add({.name = "second",
                             .role = core::Role::kSubsystem,
                             .system = 1,
                             .id = 3,
                             .links = {super_link(address_of(1))}});
  s.begin();
  const auto first = s.client(*s.host, kTwice);
  s.run_for(100ms);
  const auto second = s.client(second_host, kTwice);
  s.run_for(100ms);
  const core::Event* event = Story::find_event(*s.robot, core::EventKind::kDuplicateAddress);
  ASSERT_NE(event, nullptr);
  EXPECT_EQ(event->client.name.view(), "second");
  EXPECT_EQ(event->owner.name.view(), "host");
  EXPECT_TRUE(s.reaches(*s.base, s.gui, kGui, *s.host, first, kTwice));
  // The first mailbox is removed: the second, which was waiting, becomes known.
  s.host->remove_client(s.now(), first);
  s.run_for(100ms);
  EXPECT_TRUE(s.reaches(*s.base, s.gui, kGui, second_host, second, kTwice));
}

TEST(Identity, AddressWidthsDiffer) {
  Story s;
  s.begin();
  Node& strange = s.add({.name = "strange",
                         .role = core::Role::kSystem,
                         .system = 9,
                         .links = {super_link(address_of(0))},
                         .widths = {.system = 4, .class_id = 8, .instance = 12, .local = 8}});
  strange.start(s.now());
  s.run_for(2s);
  EXPECT_EQ(Story::links_up(strange), 0U);
  const core::Event* refused = Story::find_event(strange, core::EventKind::kLinkRefused);
  ASSERT_NE(refused, nullptr);
  EXPECT_NE(refused->text.view().find("widths"), std::string_view::npos);
  EXPECT_NE(Story::find_event(*s.base, core::EventKind::kLinkRefused), nullptr);
}

// The refusal contains both values.
TEST(Identity, PriorityClassesDiffer) {
  Story s;
  s.begin();
  Node& strange = s.add({.name = "strange",
                         .role = core::Role::kSystem,
                         .system = 9,
                         .links = {super_link(address_of(0))},
                         .classes = {{32, 64, 96, 128, 160, 192, 224}}});
  strange.start(s.now());
  s.run_for(2s);
  EXPECT_EQ(Story::links_up(strange), 0U);
  for (Node* node : {&strange, s.base}) {
    const core::Event* refused = Story::find_event(*node, core::EventKind::kLinkRefused);
    ASSERT_NE(refused, nullptr);
    for (const char* value : {"32/64/96/128/160/192/224", "0/1/15/25/35/45/100"})
      EXPECT_NE(refused->text.view().find(value), std::string_view::npos) << refused->text.view();
  }
}

TEST(Identity, TheRefusalNamesTheUnknownVersion) {
  Story s;
  s.begin();
  std::vector<std::byte> answer;
  s.tap = [&](Node&, const NetAddress& to, std::span<const std::byte> bytes) {
    if (to != address_of(900)) return false;
    answer.assign(bytes.begin(), bytes.end());
    return true;
  };
  std::array<std::byte, link::kHelloSize> hello{};
  link::ByteWriter out(hello);
  out.put(std::uint8_t{2});
  out.put(std::uint8_t{7});
  out.put(std::uint8_t{9});
  out.put(std::uint8_t{0});
  out.put_text("TIMS");
  out.put(std::uint64_t{4711});
  s.inject(address_of(900), s.base->address(), hello);
  s.run_for(10ms);
  const auto datagram = link::decode(answer);
  ASSERT_TRUE(datagram.has_value());
  const auto* refuse = std::get_if<link::Refuse>(&*datagram);
  ASSERT_NE(refuse, nullptr);
  EXPECT_EQ(refuse->echo, 4711U);
  EXPECT_EQ(refuse->code, link::RefuseCode::kVersion);
  EXPECT_NE(refuse->text.view().find("the other router supports 7 to 9"), std::string_view::npos)
      << refuse->text.view();
}

// Three routers with static routes in a circle.
TEST(Identity, StaticRoutesInACircle) {
  SimulatedNetwork w(3);
  const auto peers = [](std::size_t to) {
    return std::vector<link::LinkSettings>{peer_link(address_of(to)),
                                           {.kind = core::LinkKind::kPeer, .connects = false}};
  };
  std::array<Node*, 3> nodes{};
  for (std::size_t i = 0; i < 3; ++i)
    nodes[i] = &w.add({.name = std::string(1, static_cast<char>('a' + i)),
                       .role = core::Role::kTop,
                       .id = static_cast<std::uint8_t>(i + 1),
                       .links = peers((i + 1) % 3)});
  for (Node* node : nodes) node->start(w.now());
  w.run_for(2s);
  for (std::size_t i = 0; i < 3; ++i) {
    core::StaticRoute route;
    route.match = *AddressPattern::parse("*");
    route.via = std::string_view(nodes[(i + 1) % 3]->setup().name);
    nodes[i]->router().set_static_routes({route});
  }
  const auto client = nodes[0]->add_client(w.now(), "lost");
  const Address here(0x00100000);
  nodes[0]->add_mailbox(w.now(), client, here);
  nodes[0]->send(w.now(), client, {.type = 3, .dest = Address(0x33330000), .src = here});
  w.run_for(1s);
  const core::Event* loop = nullptr;
  for (Node* node : nodes)
    if (loop == nullptr) loop = Story::find_event(*node, core::EventKind::kLoop);
  ASSERT_NE(loop, nullptr);
  EXPECT_FALSE(loop->client.name.view().empty());
  EXPECT_FALSE(loop->owner.name.view().empty());
  EXPECT_EQ(Story::not_available(*nodes[0], client), 1U);
}

// An attacker replays recorded datagrams from another address.
TEST(Identity, ReplayedDatagramsHaveNoEffect) {
  Story s;
  std::vector<std::vector<std::byte>> captured;
  s.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
    if (&from == s.robot && to == s.base->address())
      captured.emplace_back(bytes.begin(), bytes.end());
    return false;
  };
  s.begin();
  ASSERT_TRUE(s.reaches(*s.robot, s.ladar, kLadar, *s.base, s.gui, kGui));
  s.run_for(2s);
  const auto sent = std::move(captured);
  captured.clear();
  const std::size_t arrived = s.base->arrivals(s.gui).size();
  const std::size_t events = s.base->events.size();
  for (const auto& bytes : sent) s.inject(address_of(900), s.base->address(), bytes);
  s.run_for(2s);
  EXPECT_EQ(s.base->arrivals(s.gui).size(), arrived);
  EXPECT_EQ(s.base->events.size(), events);
  EXPECT_TRUE(s.gui_reaches_camera());
}

TEST(Identity, ForgedDatagramsAreCounted) {
  Story s;
  s.begin();
  for (int i = 0; i < 1000; ++i) {
    std::vector<std::byte> bytes(s.random(300));
    for (std::byte& b : bytes) b = static_cast<std::byte>(s.random());
    if (!bytes.empty()) bytes[0] = static_cast<std::byte>(i % 6);
    s.inject(address_of(900), s.base->address(), bytes);
  }
  s.run_for(1s);
  const auto& counters = s.base->links().counters();
  EXPECT_GT(counters.strange + counters.unknown_token, 900U);
  EXPECT_TRUE(s.gui_reaches_camera());
}

TEST(Identity, APeerThatAcknowledgesPacketsNeverSent) {
  Story s;
  s.begin();
  // A forged packet of the robot acknowledges packets that were not sent yet.
  bool done = false;
  s.tap = [&](Node& from, const NetAddress& to, std::span<const std::byte> bytes) {
    if (done || &from != s.robot || to != s.base->address() || bytes[0] != std::byte{1})
      return false;
    done = true;
    std::vector<std::byte> forged(bytes.begin(), bytes.begin() + link::kDataHeaderSize);
    forged.resize(forged.size() + link::ack_size(1));
    const std::span<std::byte> all(forged);
    link::ByteWriter out(all.subspan(link::kDataHeaderSize));
    link::Ack ack{.count = 1};
    ack.ranges[0] = {1'000'000, 1'000'000};
    put(out, ack);
    s.inject(from.address(), to, forged);
    return true;
  };
  ASSERT_TRUE(s.run_until([&] { return done; }, 1s));
  s.run_for(100ms);
  const core::Event* down = Story::find_event(*s.base, core::EventKind::kLinkDown);
  ASSERT_NE(down, nullptr);
  EXPECT_EQ(down->reason, core::CloseReason::kBadRecord);
  EXPECT_TRUE(s.run_until([&] { return s.converged(); }, 4s));
}

TEST(Identity, APeerThatFloods) {
  Story s;
  s.begin();
  std::vector<std::byte> body(100'000);
  std::size_t most = 0;
  for (int i = 0; i < 500; ++i) {
    for (int n = 0; n < 4; ++n)
      s.robot->send(s.now(), s.ladar, {.type = -7, .dest = kChassis, .src = kLadar}, body);
    s.run_for(2ms);
    most = std::max({most, s.base->memory_in_use(), s.robot->memory_in_use()});
  }
  EXPECT_LE(most, 40U << 20);
  EXPECT_TRUE(s.reaches(*s.base, s.gui, kGui, *s.other, s.chassis, kChassis));
}

TEST(Identity, TheNumberOfLinksIsLimited) {
  SimulatedNetwork w(5);
  Node& base =
      w.add({.name = "base", .role = core::Role::kTop, .links = {sub_link()}, .links_max = 2});
  base.start(w.now());
  std::size_t up = 0;
  for (std::uint8_t i = 1; i <= 4; ++i) {
    Node& robot = w.add(
        {.name = "robot" + std::to_string(i), .system = i, .links = {super_link(address_of(0))}});
    robot.start(w.now());
    w.run_for(1s);
    up += Story::links_up(robot);
    EXPECT_EQ(Story::find_event(robot, core::EventKind::kLinkRefused) != nullptr, i > 2);
  }
  EXPECT_EQ(up, 2U);
  // Links of routers that do not return are removed, which makes room.
  w.nodes()[1]->kill();
  w.nodes()[2]->kill();
  w.run_for(120s);
  EXPECT_EQ(Story::links_up(base), 2U);
}

// A base that accepts few mailboxes from a link, and a robot with many.
TEST(Identity, TheNumberOfMailboxesOfALinkIsLimited) {
  SimulatedNetwork w(5);
  auto few = sub_link();
  few.mailboxes_max = 101;  // including the router's own
  Node& base = w.add({.name = "base", .role = core::Role::kTop, .links = {few}});
  Node& robot = w.add({.name = "robot", .system = 1, .links = {super_link(address_of(0))}});
  Node& other = w.add({.name = "other", .system = 2, .links = {super_link(address_of(0))}});
  for (Node* node : {&base, &robot, &other}) node->start(w.now());
  const auto client = robot.add_client(w.now(), "many");
  const auto mailbox = [](std::uint32_t n) { return Address(0x01140000 + n); };
  const auto known = [&] {
    std::size_t count = 0;
    for (std::uint32_t n = 0; n < 300; ++n) count += Story::knows(base, mailbox(n)) ? 1U : 0U;
    return count;
  };
  for (std::uint32_t n = 0; n < 100; ++n) robot.add_mailbox(w.now(), client, mailbox(n));
  w.run_for(5s);
  EXPECT_EQ(known(), 100U);
  EXPECT_EQ(Story::find_event(base, core::EventKind::kMailboxLimit), nullptr);
  for (std::uint32_t n = 100; n < 300; ++n) robot.add_mailbox(w.now(), client, mailbox(n));
  w.run_for(30s);
  EXPECT_EQ(known(), 100U);
  const core::Event* limit = Story::find_event(base, core::EventKind::kMailboxLimit);
  ASSERT_NE(limit, nullptr);
  EXPECT_EQ(limit->client.name.view(), "robot");
  EXPECT_EQ(Story::links_up(base), 2U) << "the existing links are kept";
  EXPECT_EQ(Story::find_event(base, core::EventKind::kLinkDown), nullptr);
  std::size_t refused = 0;
  base.links().for_each([&](const link::Link& link) { refused += link.mailboxes_refused(); });
  EXPECT_GE(refused, 200U);
  // There is room again: the mailboxes refused before are accepted.
  for (std::uint32_t n = 0; n < 200; ++n)
    robot.router().remove_mailbox(w.now(), client, mailbox(n));
  robot.end_turn(w.now());
  EXPECT_TRUE(w.run_until([&] { return Story::knows(base, mailbox(299)); }, 15s));
  EXPECT_EQ(known(), 100U);
}

// A router brings mailboxes and messages of its own system only: a stolen robot can pretend what is
// inside it, and nothing else.
TEST(Identity, ARobotTransfersNothingOfOtherSystems) {
  SimulatedNetwork w(5);
  Node& base = w.add({.name = "base", .role = core::Role::kTop, .links = {sub_link()}});
  Node& robot = w.add({.name = "robot", .system = 1, .links = {super_link(address_of(0))}});
  Node& other = w.add({.name = "other", .system = 2, .links = {super_link(address_of(0))}});
  for (Node* node : {&base, &robot, &other}) node->start(w.now());
  const auto client = robot.add_client(w.now(), "both");
  const Address own(0x01140000);
  const Address foreign(0x02140000);
  robot.add_mailbox(w.now(), client, own);
  robot.add_mailbox(w.now(), client, foreign);
  w.run_for(10s);
  EXPECT_TRUE(Story::knows(base, own));
  EXPECT_FALSE(Story::knows(base, foreign));
  const core::Event* event = Story::find_event(base, core::EventKind::kAddressRefused);
  ASSERT_NE(event, nullptr);
  EXPECT_EQ(event->address, foreign);
  EXPECT_EQ(event->client.name.view(), "robot");
  EXPECT_EQ(Story::links_up(base), 2U);

  const auto gui = base.add_client(w.now(), "gui");
  base.add_mailbox(w.now(), gui, kGui);
  w.run_for(1s);
  for (const Address src : {foreign, own, foreign})
    robot.send(w.now(), client, {.type = -7, .dest = kGui, .src = src});
  w.run_for(1s);
  ASSERT_EQ(base.arrivals(gui).size(), 1U);
  EXPECT_EQ(base.arrivals(gui)[0].header.src, own);
  EXPECT_EQ(base.router().messages().total(core::Outcome::kForgedSource).messages, 2U);
  EXPECT_EQ(Story::not_available(robot, client), 0U);
  robot.send(w.now(), client, {.type = 3, .dest = kGui, .src = foreign});
  EXPECT_TRUE(w.run_until([&] { return Story::not_available(robot, client) == 1; }, 100ms))
      << "a command is not left without an answer";
  EXPECT_EQ(base.arrivals(gui).size(), 1U);
}

// A link may be restricted to one system; a router of another one does not get that far.
TEST(Identity, ALinkForOneSystemAcceptsNoOther) {
  SimulatedNetwork w(5);
  Node& base = w.add({.name = "base", .role = core::Role::kTop, .links = {sub_link(1)}});
  Node& robot = w.add({.name = "robot", .system = 1, .links = {super_link(address_of(0))}});
  Node& other = w.add({.name = "other", .system = 2, .links = {super_link(address_of(0))}});
  for (Node* node : {&base, &robot, &other}) node->start(w.now());
  w.run_for(1s);
  EXPECT_EQ(Story::links_up(robot), 1U);
  EXPECT_EQ(Story::links_up(other), 0U);
}

// What is here or below cannot come from above.
TEST(Identity, ARouterAboveCannotPretendToBeAComponentOfTheRobot) {
  Story s;
  s.begin();
  const auto impostor = s.base->add_client(s.now(), "impostor", core::PortKind::kWebSocket);
  const std::size_t before = s.robot->arrivals(s.ladar).size();
  for (const Address src : {kLadar, kCamera})
    s.base->send(s.now(), impostor, {.type = 3, .dest = kLadar, .src = src});
  s.run_for(100ms);
  EXPECT_EQ(s.robot->arrivals(s.ladar).size(), before);
  EXPECT_EQ(s.robot->router().messages().total(core::Outcome::kForgedSource).messages, 2U);
  EXPECT_TRUE(s.reaches(*s.base, s.gui, kGui, *s.robot, s.ladar, kLadar));
}

}  // namespace stories_identity
}  // namespace tims::sim
