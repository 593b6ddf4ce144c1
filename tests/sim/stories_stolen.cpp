// A robot that was broken into has its keys and its link, and sends what it likes over it.
#include <string_view>
#include <tuple>

#include "tests/sim/story.h"
#include "wire/header.h"

namespace tims::sim {
namespace stories_stolen {

struct Stolen : Story {
  Stolen() : Story(1, {}, core::Compression::kOff, true) { begin(); }

  // Past the checks of the robot's own router.
  void send_over_link(const Header& header, std::uint8_t hops = 0,
                      const std::vector<std::byte>& body = std::vector<std::byte>(4)) {
    std::vector<std::byte> bytes(kHeaderSize);
    bytes.insert(bytes.end(), body.begin(), body.end());
    Header whole = header;
    whole.length = static_cast<std::uint32_t>(bytes.size());
    wire::encode_header(whole, std::span(bytes).first<kHeaderSize>());
    robot->links().for_each([&](const link::Link& one) {
      if (one.peer().name.view() != "base") return;
      (void)robot->links().deliver(now(), {.token = one.slot()},
                                   {.header = whole, .bytes = bytes, .hops = hops});
    });
    robot->end_turn(now());
    run_for(100ms);
  }
  // A question of a program at the robot to a router, or to the agent beside it.
  void ask_over_link(Address to, std::string_view question) {
    const auto bytes = std::as_bytes(std::span(question));
    send_over_link({.type = type::kAdminRequest, .dest = to, .src = kLadar}, 0,
                   {bytes.begin(), bytes.end()});
  }
  [[nodiscard]] std::uint64_t at_base(core::Outcome outcome) {
    return base->router().messages().total(outcome).messages;
  }
};

// Commands for routers, as programs send them to their own: to register, to remove, to connect.
TEST(StolenRobot, CommandsForTheRouterAboveAreNotCarriedOut) {
  Stolen s;
  std::uint64_t sent = 0;
  for (int type = -128; type < 128; ++type) {
    for (const Address src : {Address(), kChassis, kGui, kLadar}) {
      s.send_over_link({.type = static_cast<std::int8_t>(type), .dest = Address(), .src = src});
      ++sent;
    }
  }
  EXPECT_GT(sent, 0U);
  EXPECT_TRUE(s.converged());
  EXPECT_TRUE(s.reaches(*s.base, s.gui, kGui, *s.other, s.chassis, kChassis));
  EXPECT_TRUE(s.gui_reaches_camera());
  EXPECT_EQ(Story::links_up(*s.base), 2U);
}

TEST(StolenRobot, SourcesOfOthersAreCountedAndNotPassedOn) {
  Stolen s;
  const std::size_t before = s.other->arrivals(s.chassis).size();
  for (const std::uint8_t flags : {std::uint8_t{0}, flag::kTrace, flag::kStream})
    for (const Address src : {kGui, kChassis, Address(), Address(0x00000001), kLadar})
      s.send_over_link({.flags = flags, .type = type::kData, .dest = kChassis, .src = src});
  EXPECT_EQ(s.at_base(core::Outcome::kForgedSource), 12U);
  EXPECT_EQ(s.other->arrivals(s.chassis).size(), before + 3) << "its own";
}

// The mailbox that data are sent to, or not any more, is named in the body.
TEST(StolenRobot, DataAreAskedForItsOwnMailboxesOnly) {
  Stolen s;
  std::size_t expected = s.other->arrivals(s.chassis).size();
  for (const std::int8_t type : {type::kGetContData, type::kStopContData}) {
    for (const Address mailbox : {kGui, kChassis, kLadar}) {
      std::vector<std::byte> body(type == type::kGetContData ? 4 : 0);
      for (int shift = 24; shift >= 0; shift -= 8)
        body.push_back(static_cast<std::byte>(mailbox.raw() >> shift & 0xFF));
      s.send_over_link({.flags = 0, .type = type, .dest = kChassis, .src = kLadar}, 0, body);
    }
    ++expected;
  }
  EXPECT_EQ(s.at_base(core::Outcome::kForgedSource), 4U);
  EXPECT_EQ(s.other->arrivals(s.chassis).size(), expected) << "its own";
}

TEST(StolenRobot, MessagesThatClaimToHaveComeFarEnd) {
  Stolen s;
  const std::size_t before = s.other->arrivals(s.chassis).size();
  for (const std::uint8_t hops : {std::uint8_t{254}, std::uint8_t{core::kHopsMax - 1}})
    s.send_over_link({.type = 3, .dest = kChassis, .src = kLadar}, hops);
  EXPECT_EQ(s.other->arrivals(s.chassis).size(), before);
  EXPECT_EQ(s.at_base(core::Outcome::kHopLimit), 2U);
  s.send_over_link({.type = 3, .dest = kChassis, .src = kLadar}, core::kHopsMax - 2);
  EXPECT_EQ(s.other->arrivals(s.chassis).size(), before + 1);
  EXPECT_EQ(Story::links_up(*s.base), 2U);
}

constexpr Address kBaseRouter{0x00000100};   // Tims(0/1)
constexpr Address kOtherRouter{0x02000100};  // Tims(2/1), behind the base
constexpr Address kHostRouter{0x01000200};   // Tims(1/2), the robot's own second host
constexpr Address agent_of(Address router) { return Address(router.raw() + 1); }

constexpr std::string_view kStatus = R"({"ask":"status"})";
constexpr std::string_view kLease = R"({"ask":"lease","robot":2,"do":"take","name":"x"})";
constexpr std::string_view kRouteAdd = R"x({"ask":"route_add","match":"*(2/*)","via":"robot"})x";
constexpr std::string_view kLinkDown = R"({"ask":"link","link":"other","do":"down"})";
constexpr std::string_view kNewer = R"({"ask":"forget_all"})";
constexpr std::string_view kList = R"({"ask":"conf_list"})";
constexpr std::string_view kApply = R"({"ask":"conf_apply","edits":[]})";
constexpr std::string_view kPeer = R"({"ask":"conf_peer","change":"0123456789abcdef"})";

// The default, without any rules: it looks, and changes no router, neither the one above nor,
// through that, those of others. By a route of its own it could speak for them afterwards.
TEST(StolenRobot, ChangesNoRouterAboveAndNoneOfOthers) {
  Stolen s;
  for (const std::string_view change : {kRouteAdd, kLinkDown}) {
    s.ask_over_link(kBaseRouter, change);
    s.ask_over_link(kOtherRouter, change);
  }
  s.ask_over_link(kOtherRouter, kNewer);
  EXPECT_TRUE(s.base->questions.empty());
  EXPECT_TRUE(s.other->questions.empty());
  ASSERT_EQ(s.base->denied.size(), 5U);
  EXPECT_EQ(s.base->denied.front(), "rule \"(other robots)\" for router:robot");
  EXPECT_EQ(s.at_base(core::Outcome::kDenied), 5U);
  const core::Event* denied = Story::find_event(*s.base, core::EventKind::kDenied);
  ASSERT_NE(denied, nullptr) << "in the audit log";
  EXPECT_EQ(denied->client.name.view(), "robot");
  s.ask_over_link(kBaseRouter, kStatus);
  s.ask_over_link(kOtherRouter, kStatus);
  s.ask_over_link(kBaseRouter, kLease);
  EXPECT_EQ(s.base->questions,
            (std::vector<std::string>{std::string(kStatus), std::string(kLease)}));
  EXPECT_EQ(s.other->questions, std::vector<std::string>{std::string(kStatus)});
}

TEST(StolenRobot, ChangesNoFilesAboveAndNoneOfOthers) {
  Stolen s;
  const core::ClientId of_base = s.client(*s.base, agent_of(kBaseRouter));
  const core::ClientId of_other = s.client(*s.other, agent_of(kOtherRouter));
  s.run_for(100ms);
  for (const std::string_view question : {kApply, kNewer, std::string_view("{")}) {
    s.ask_over_link(agent_of(kBaseRouter), question);
    s.ask_over_link(agent_of(kOtherRouter), question);
  }
  EXPECT_TRUE(s.base->arrivals(of_base).empty());
  EXPECT_TRUE(s.other->arrivals(of_other).empty());
  EXPECT_EQ(s.base->denied.size(), 6U);
  // To look is everybody's, and the agents of one change agree about it.
  for (const std::string_view question : {kList, kPeer}) {
    s.ask_over_link(agent_of(kBaseRouter), question);
    s.ask_over_link(agent_of(kOtherRouter), question);
  }
  EXPECT_EQ(s.base->arrivals(of_base).size(), 2U);
  EXPECT_EQ(s.other->arrivals(of_other).size(), 2U);
}

TEST(StolenRobot, ChangesNoRouterBeside) {
  SimulatedNetwork w(7);
  w.seal_all();
  w.judge_all();
  Node& one = w.add({.name = "one", .system = 1, .links = {peer_link(address_of(1))}});
  Node& two = w.add(
      {.name = "two", .system = 2, .links = {{.kind = core::LinkKind::kPeer, .connects = false}}});
  for (Node* node : {&one, &two}) node->start(w.now());
  const core::ClientId thief = one.add_client(w.now(), "thief");
  ASSERT_TRUE(one.add_mailbox(w.now(), thief, kLadar));
  w.run_for(1s);
  for (const std::string_view question : {kRouteAdd, kStatus}) {
    (void)one.send(w.now(), thief,
                   {.type = type::kAdminRequest, .dest = kOtherRouter, .src = kLadar},
                   std::as_bytes(std::span(question)));
    w.run_for(100ms);
  }
  EXPECT_EQ(two.questions, std::vector<std::string>{std::string(kStatus)});
  EXPECT_EQ(two.denied, std::vector<std::string>{"rule \"(other robots)\" for router:one"});
}

// Who operates robots goes on doing so: from above, and within a robot between its hosts.
TEST(StolenRobot, OperatorsAboveAndTheRobotsOwnHostsChangeRouters) {
  Stolen s;
  const auto ask = [&](Node& from, core::ClientId client, Address src, Address to) {
    (void)from.send(s.now(), client, {.type = type::kAdminRequest, .dest = to, .src = src},
                    std::as_bytes(std::span(kLinkDown)));
    s.run_for(100ms);
  };
  constexpr Address kRobotRouter{0x01000100};
  const std::vector<std::string> asked{std::string(kLinkDown)};
  ask(*s.base, s.gui, kGui, kOtherRouter);
  EXPECT_EQ(s.other->questions, asked);
  ask(*s.base, s.gui, kGui, kHostRouter);
  EXPECT_EQ(s.host->questions, asked) << "through the router of the robot";
  ask(*s.host, s.camera, kCamera, kRobotRouter);
  EXPECT_EQ(s.robot->questions, asked);
  for (Node* node : {s.base, s.robot, s.host, s.other}) EXPECT_TRUE(node->denied.empty());
}

TEST(StolenRobot, ARuleThatNamesARobotLetsItChangeRouters) {
  Story s(1,
          {.rules = policy::PolicyText{.rules = {{.name = "mother ship",
                                                  .from = "router:robot",
                                                  .types = "change",
                                                  .then = "allow"}}}},
          core::Compression::kOff, true);
  s.begin();
  for (const auto& [node, client, src] :
       {std::tuple(s.robot, s.ladar, kLadar), std::tuple(s.other, s.chassis, kChassis)}) {
    (void)node->send(s.now(), client,
                     {.type = type::kAdminRequest, .dest = kBaseRouter, .src = src},
                     std::as_bytes(std::span(kLinkDown)));
    s.run_for(100ms);
  }
  EXPECT_EQ(s.base->questions.size(), 1U);
  EXPECT_EQ(s.base->denied, std::vector<std::string>{"rule \"(other robots)\" for router:other"});
}

// As before: nobody there has proven anything.
TEST(StolenRobot, WithoutKeysRobotsChangeEachOther) {
  Story s(1, {.rules = policy::PolicyText{}});
  s.begin();
  (void)s.robot->send(s.now(), s.ladar,
                      {.type = type::kAdminRequest, .dest = kBaseRouter, .src = kLadar},
                      std::as_bytes(std::span(kLinkDown)));
  s.run_for(100ms);
  EXPECT_EQ(s.base->questions.size(), 1U);
}

// Static routes name routers. A route leads to whose certificate has the name, whatever routers
// call themselves.
struct Routed : SimulatedNetwork {
  static constexpr Address kFar{0x09180000};

  Routed() : SimulatedNetwork(7) {
    seal_all();
    base = &add({.name = "base", .role = core::Role::kTop, .links = {sub_link()}});
    liar =
        &add({.name = "robot3",
              .system = 4,
              .links = {super_link(address_of(0))},
              .keys = ToyKeys{
                  .fleet = 1,
                  .name = {.role = core::Role::kSystem, .system = 4, .id = 1, .name = "robot4"}}});
    robot = &add({.name = "robot3", .system = 3, .links = {super_link(address_of(0))}});
    base->start(now());
    base->router().set_static_routes(
        {{*AddressPattern::parse("Pilot(9/*)"), "Pilot(9/*)", "robot3"}});
    liar->start(now());
    run_for(1s);
  }
  // 0: nowhere
  [[nodiscard]] std::uint16_t leads_to() const {
    const core::NextHop hop = base->router().routes().next_hop(nullptr, kFar);
    return hop.to == nullptr ? std::uint16_t{0} : hop.to->info.link.system;
  }
  [[nodiscard]] bool may_come_from(std::uint16_t system) const {
    bool may = false;
    base->router().clients().for_each([&](const core::Client& client) {
      may =
          may || (client.info.link.system == system && client.info.port == core::PortKind::kLink &&
                  base->router().routes().may_come_from(client, kFar));
    });
    return may;
  }
  static void rename(SimulatedNetwork& network, Node& node, const std::string& name) {
    ToyKeys keys = *node.setup().keys;
    keys.name.name = name;
    node.renew(network.now(), keys);
  }

  Node* base;
  Node* liar;
  Node* robot;
};

TEST(StolenRobot, ARouteIsNotTakenByWhoCallsItselfLikeAnother) {
  Routed s;
  ASSERT_EQ(Story::links_up(*s.base), 1U);
  EXPECT_EQ(s.leads_to(), 0U);
  EXPECT_FALSE(s.may_come_from(4));
  s.robot->start(s.now());
  s.run_for(1s);
  EXPECT_EQ(s.leads_to(), 3U);
  EXPECT_TRUE(s.may_come_from(3));
  EXPECT_FALSE(s.may_come_from(4));
  s.robot->kill();
  s.run_for(5s);
  EXPECT_EQ(s.leads_to(), 0U);
  s.base->links().for_each([](const link::Link& link) {
    EXPECT_TRUE(link.peer().system != 4 || link.peer().name.view() == "robot4");
  });
}

// At the next handshake, which is at once: neither the link goes down nor does anything wait.
TEST(StolenRobot, ACertificateWithAnotherNameCountsForRulesAndRoutesAtOnce) {
  Routed s;
  s.robot->start(s.now());
  s.run_for(1s);
  const auto robot_subject = [&] {
    return s.base->router().routes().next_hop(nullptr, Routed::kFar).to->info.subject.name;
  };
  EXPECT_EQ(robot_subject(), "router:robot3");
  Routed::rename(s, *s.robot, "robot3-old");
  s.run_for(100ms);
  EXPECT_EQ(s.leads_to(), 0U);
  const core::Event* renamed = Story::find_event(*s.base, core::EventKind::kLinkRenamed);
  ASSERT_NE(renamed, nullptr);
  EXPECT_EQ(renamed->client.name.view(), "robot3-old");
  EXPECT_EQ(renamed->text.view(), "robot3");
  Routed::rename(s, *s.liar, "robot3");
  s.run_for(100ms);
  EXPECT_EQ(s.leads_to(), 4U) << "the authority has given it the name";
  EXPECT_EQ(robot_subject(), "router:robot3");
  EXPECT_EQ(Story::find_event(*s.base, core::EventKind::kLinkDown), nullptr);
}

// Robot 1 calls robot 2, and robot 3 sits in between: it answers a new handshake of the session
// with its own certificate, and pretends to be the other end of it.
TEST(StolenRobot, DoesNotGoOnWithTheSessionOfAnother) {
  SimulatedNetwork w(7);
  w.seal_all();
  const link::LinkSettings accepts{.kind = core::LinkKind::kPeer, .connects = false};
  Node& one = w.add({.name = "one", .system = 1, .links = {peer_link(address_of(1))}});
  Node& two = w.add({.name = "two", .system = 2, .links = {accepts}});
  Node& three = w.add({.name = "three", .system = 3, .links = {accepts}});
  for (Node* node : {&one, &two}) node->start(w.now());
  w.run_for(1s);
  ASSERT_EQ(Story::links_up(one), 1U);
  std::uint64_t token = 0;
  two.links().for_each([&](const link::Link& link) { token = link.our_token(); });
  two.kill();
  ToyKeys keys = *three.setup().keys;
  keys.alter = [token](std::vector<std::byte>& message) {
    const auto datagram = link::decode(message);
    const auto* welcome = datagram ? std::get_if<link::Welcome>(&*datagram) : nullptr;
    if (welcome == nullptr) return;
    link::Welcome lie = *welcome;
    lie.resumed = true;
    lie.generation = 1;
    lie.token = token;
    std::array<std::byte, link::kControlDatagramMax> bytes{};
    const std::size_t size = link::encode(lie, bytes);
    message.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
  };
  three.start(w.now());
  three.renew(w.now(), keys);
  three.move_to(address_of(1));
  one.links().renew_keys(w.now());
  one.end_turn(w.now());
  w.run_for(500ms);
  std::size_t subjects = 0;
  one.router().clients().for_each([&](const core::Client& client) {
    if (client.info.port != core::PortKind::kLink) return;
    ++subjects;
    EXPECT_EQ(client.info.subject.name, "router:three");
    EXPECT_EQ(client.info.link.system, 3U);
  });
  EXPECT_EQ(subjects, 1U);
}

}  // namespace stories_stolen
}  // namespace tims::sim
