// The policy at the router: what is judged, and what becomes of it.
#include "router/core/report.h"
#include "router/core/router_fixture.h"

namespace tims::core::test {
namespace router_policy_test {

constexpr Address kChassis{0x00110000};
constexpr Address kLadar{0x00140000};
constexpr Address kTool{0x000F0100};
constexpr std::int8_t kMove = 21;

policy::Policy compiled(std::vector<policy::RuleText> rules) {
  std::vector<policy::Problem> problems;
  auto policy = policy::Policy::compile({.rules = std::move(rules)}, {}, problems);
  for (const policy::Problem& problem : problems) ADD_FAILURE() << problem.text;
  return policy.value_or(policy::Policy());
}

class RouterPolicyTest : public RouterTest {
 protected:
  RouterPolicyTest() { router_.judge_by(enforcer_); }

  void set(std::vector<policy::RuleText> rules) {
    router_.set_policy(now_, compiled(std::move(rules)));
  }
  ClientId enter(PortKind port, std::string_view who) {
    return router_.connect(
        now_, {.port = port, .token = ++token_, .subject = *policy::Subject::parse(who)});
  }
  ClientId enter(PortKind port, std::string_view who, Address mailbox) {
    const ClientId id = enter(port, who);
    EXPECT_EQ(router_.register_mailbox(now_, id, mailbox).status, Registration::Status::kOk);
    return id;
  }
  static Header header(std::int8_t type, Address dest, Address src, std::uint8_t priority = 0) {
    return {.type = type, .priority = priority, .dest = dest, .src = src};
  }

  // To the ladar, with a body that is big-endian.
  static Header about_stream(std::int8_t type, Address src) {
    Header asking = header(type, kLadar, src);
    asking.flags = 0;
    return asking;
  }
  // The body of GET_CONT_DATA.
  static Bytes subscription_for(Address mailbox) {
    Bytes body(4);
    for (int shift = 24; shift >= 0; shift -= 8)
      body.push_back(std::byte(mailbox.raw() >> shift & 0xFF));
    return body;
  }

  // What may be looked at but not driven by guests.
  const std::vector<policy::RuleText> guests_{{.name = "own", .from = "own", .then = "allow"},
                                              {.name = "guests look",
                                               .from = "user:guest",
                                               .types = "look",
                                               .priority_max = 20,
                                               .then = "allow",
                                               .place = "router.toml:7"}};
  policy::Enforcer enforcer_{compiled({}), 7};
};

TEST_F(RouterPolicyTest, WithoutRulesNothingIsJudged) {
  enter(PortKind::kLocal, "own", kChassis);
  const ClientId guest = enter(PortKind::kTcp, "user:guest", kTool);
  EXPECT_FALSE(router_.client(guest)->is_judged());
  EXPECT_EQ(send(guest, header(kMove, kChassis, kTool, 255)), Outcome::kDelivered);
  EXPECT_EQ(sink_.delivered.back().header.priority, 255);
  EXPECT_EQ(send(guest, header(kMove, kChassis, kLadar)), Outcome::kDelivered)
      << "forged sources of TCP clients are tolerated as before";
}

TEST_F(RouterPolicyTest, ADeniedCommandIsAnsweredNotAvailableAndReportedOnce) {
  set(guests_);
  enter(PortKind::kLocal, "own", kChassis);
  const ClientId guest = enter(PortKind::kTcp, "user:guest", kTool);
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(send(guest, header(kMove, kChassis, kTool)), Outcome::kDenied);
  EXPECT_TRUE(sink_.delivered.empty());
  ASSERT_EQ(sink_.replies.size(), 3U);
  EXPECT_EQ(sink_.replies.back().header.type, type::kNotAvailable);
  EXPECT_EQ(sink_.replies.back().header.dest, kTool);
  EXPECT_EQ(count(EventKind::kDenied), 1U);
  EXPECT_EQ(sink_.events.back().text.view(), "type 21 by rule \"(none)\" for user:guest");
  // The others are counted, and reported after a minute.
  now_ += policy::Enforcer::kReportEvery;
  EXPECT_EQ(router_.next_timeout(), now_);
  router_.on_timeout(now_);
  EXPECT_EQ(sink_.events.back().text.view(), "2 more messages by rule \"(none)\" for user:guest");
}

TEST_F(RouterPolicyTest, WhatPassesIsLoweredToThePriorityOfItsRule) {
  set(guests_);
  enter(PortKind::kLocal, "own", kChassis);
  const ClientId guest = enter(PortKind::kTcp, "user:guest", kTool);
  EXPECT_EQ(send(guest, header(type::kGetStatus, kChassis, kTool, 255)), Outcome::kDelivered);
  EXPECT_EQ(sink_.delivered.back().header.priority, 20);
  EXPECT_EQ(
      wire::decode_header(std::span(sink_.delivered.back().bytes).first<kHeaderSize>()).priority,
      20)
      << "and in its bytes";
}

// The mailbox that data are sent to is named in the body.
TEST_F(RouterPolicyTest, ASubscriptionForSomebodyElseIsForged) {
  set(guests_);
  enter(PortKind::kLocal, "own", kChassis);
  enter(PortKind::kLocal, "own", kLadar);
  const ClientId guest = enter(PortKind::kTcp, "user:guest", kTool);
  const Header ask = about_stream(type::kGetContData, kTool);
  EXPECT_EQ(send(guest, ask, subscription_for(kChassis)), Outcome::kForgedSource);
  EXPECT_EQ(send(guest, ask, subscription_for(kTool)), Outcome::kDelivered);
  EXPECT_EQ(send(guest, ask, subscription_for(kChassis)), Outcome::kForgedSource)
      << "although the same header has just passed";
  EXPECT_EQ(send(guest, ask), Outcome::kDelivered) << "its component refuses it";
  EXPECT_EQ(send(guest, ask, subscription_for(kChassis)), Outcome::kForgedSource);
}

// A robot has streams sent to its own mailboxes only, whether or not there are rules.
TEST_F(RouterPolicyTest, ASubscriptionForAnotherRobotIsForgedOverALinkToo) {
  enter(PortKind::kLocal, "own", kChassis);
  enter(PortKind::kLocal, "own", kLadar);
  constexpr Address kOfRobot3{0x03180000};
  const ClientId robot = link(LinkKind::kSub, 3, "robot3");
  ASSERT_TRUE(router_.learn(now_, robot, kOfRobot3, {.router = Address(0x03000100), .hops = 1}));
  const ClientId base = link(LinkKind::kSuper, 9, "base");
  const Header ask = about_stream(type::kGetContData, kOfRobot3);
  EXPECT_EQ(send(robot, ask, subscription_for(kOfRobot3)), Outcome::kDelivered);
  EXPECT_EQ(send(robot, ask, subscription_for(Address(0x03180001))), Outcome::kDelivered);
  EXPECT_EQ(send(robot, ask, subscription_for(kChassis)), Outcome::kForgedSource);
  EXPECT_EQ(send(robot, ask, subscription_for(Address(0x05180000))), Outcome::kForgedSource);
  Header stop = about_stream(type::kStopContData, kOfRobot3);
  Bytes body = subscription_for(kChassis);
  body.erase(body.begin(), body.begin() + 4);
  EXPECT_EQ(send(robot, stop, body), Outcome::kForgedSource) << "nor stops those of others";
  stop.flags = flag::kNativeOrder;
  std::ranges::reverse(body);
  EXPECT_EQ(send(robot, stop, body), Outcome::kForgedSource);
  const Header above = about_stream(type::kGetContData, kTool);
  EXPECT_EQ(send(base, above, subscription_for(kTool)), Outcome::kDelivered);
  EXPECT_EQ(send(base, above, subscription_for(kChassis)), Outcome::kForgedSource);
  EXPECT_EQ(count(PortKind::kLink, Outcome::kForgedSource), 5U);
}

TEST_F(RouterPolicyTest, AJudgedClientSendsFromItsOwnMailboxesOnly) {
  set(guests_);
  enter(PortKind::kLocal, "own", kChassis);
  const ClientId guest = enter(PortKind::kTcp, "user:guest", kTool);
  EXPECT_EQ(send(guest, header(type::kGetStatus, kChassis, kLadar)), Outcome::kForgedSource);
}

// Streams are not judged message by message: what may change a verdict is looked at nevertheless.
TEST_F(RouterPolicyTest, WhatHasPassedPassesAgainUntilSomethingDiffers) {
  set(guests_);
  enter(PortKind::kLocal, "own", kChassis);
  const ClientId guest = enter(PortKind::kTcp, "user:guest", kTool);
  const Header status = header(type::kGetStatus, kChassis, kTool, 20);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(send(guest, status), Outcome::kDelivered);
  EXPECT_EQ(enforcer_.hits(1).messages, 3U);
  EXPECT_EQ(enforcer_.hits(1).bytes, 3U * kHeaderSize);
  EXPECT_EQ(send(guest, header(type::kOn, kChassis, kTool, 20)), Outcome::kDenied);
  EXPECT_EQ(send(guest, header(type::kGetStatus, kChassis, kLadar, 20)), Outcome::kForgedSource);
  EXPECT_EQ(send(guest, header(type::kGetStatus, kChassis, kTool, 21)), Outcome::kDelivered);
  EXPECT_EQ(sink_.delivered.back().header.priority, 20);
  Header traced = status;
  traced.flags = flag::kTrace;
  EXPECT_EQ(send(guest, traced), Outcome::kDelivered);
  EXPECT_TRUE(sink_.traces.empty());
  std::vector<policy::RuleText> rules = guests_;
  rules[1].then = "deny";
  rules[1].priority_max = 255;
  set(rules);
  EXPECT_EQ(send(guest, status), Outcome::kDenied) << "a reload applies at once";
  EXPECT_EQ(enforcer_.hits(1).denied, 1U);
}

TEST_F(RouterPolicyTest, AnAnswerNeedsNoRuleForAMinute) {
  set(guests_);
  const ClientId own = enter(PortKind::kLocal, "own", kChassis);
  const ClientId guest = enter(PortKind::kTcp, "user:guest", kTool);
  const Header answer = header(type::kOk, kChassis, kTool, 255);
  EXPECT_EQ(send(guest, answer), Outcome::kDenied);
  EXPECT_TRUE(sink_.replies.empty()) << "answers are not answered";
  EXPECT_EQ(send(own, header(type::kOn, kTool, kChassis)), Outcome::kDelivered);
  EXPECT_EQ(send(guest, answer), Outcome::kDelivered);
  EXPECT_LT(sink_.delivered.back().header.priority, 100) << "no answer is as urgent as a stop";
  now_ += policy::Conversations::kTime;
  EXPECT_EQ(send(guest, answer), Outcome::kDenied);
}

TEST_F(RouterPolicyTest, QuestionsToRoutersAreMessagesToo) {
  std::vector<policy::RuleText> rules = guests_;
  rules[1].types = "get_status";
  set(rules);
  const ClientId guest = enter(PortKind::kTcp, "user:guest", kTool);
  const ClientId own = enter(PortKind::kTcp, "own");
  EXPECT_EQ(send(guest, header(type::kAdminRequest, kOwn, kTool)), Outcome::kDenied);
  EXPECT_EQ(send(guest, header(type::kAdminRequest, Address(), Address())), Outcome::kDenied);
  EXPECT_TRUE(sink_.questions.empty());
  ASSERT_EQ(sink_.denied.size(), 2U);
  EXPECT_EQ(sink_.denied.back(), "rule \"(none)\" for user:guest");
  EXPECT_EQ(send(own, header(type::kAdminRequest, Address(), Address())), Outcome::kHandled);
  EXPECT_EQ(sink_.questions.size(), 1U);
}

// Else who has made a mistake in the rules could not see which.
TEST_F(RouterPolicyTest, WhoWritesTheRulesMayAlwaysLookAtThisRouter) {
  set({{.name = "nobody", .then = "deny"}});
  const ClientId writer = router_.connect(now_, {.port = PortKind::kLocal,
                                                 .token = ++token_,
                                                 .uid = sink_.writer,
                                                 .subject = *policy::Subject::parse("own")});
  ASSERT_EQ(router_.register_mailbox(now_, writer, kTool).status, Registration::Status::kOk);
  const Header question = header(type::kAdminRequest, kOwn, kTool);
  EXPECT_EQ(send(writer, question), Outcome::kHandled);
  EXPECT_EQ(send(writer, header(type::kAdminRequest, Address(0x03000100), kTool)), Outcome::kDenied)
      << "another router";
  EXPECT_EQ(send(writer, header(type::kGetStatus, kOwn, kTool)), Outcome::kDenied);
  sink_.right = policy::Right::kChange;
  EXPECT_EQ(send(writer, question), Outcome::kDenied);
}

TEST_F(RouterPolicyTest, TracingIsARightOfItsOwn) {
  set(guests_);
  enter(PortKind::kLocal, "own", kChassis);
  const ClientId guest = enter(PortKind::kWebSocket, "user:guest", kTool);
  Header traced = header(type::kGetStatus, kChassis, kTool);
  traced.flags = flag::kTrace;
  EXPECT_EQ(send(guest, traced), Outcome::kDelivered);
  EXPECT_TRUE(sink_.traces.empty()) << "its flag was removed";
  traced.type = kMove;
  EXPECT_EQ(send(guest, traced), Outcome::kDenied);
  EXPECT_EQ(sink_.traces_denied, 1);
  std::vector<policy::RuleText> rules = guests_;
  rules[1].types = "look, trace";
  set(rules);
  traced.type = type::kGetStatus;
  EXPECT_EQ(send(guest, traced), Outcome::kDelivered);
  EXPECT_EQ(sink_.traces.size(), 1U);
}

// Routers are met only by rules that name them: their messages were judged where they entered.
TEST_F(RouterPolicyTest, RoutersAreMetByRulesThatNameThem) {
  enter(PortKind::kLocal, "own", kChassis);
  const ClientId peer = router_.connect(
      now_, {.port = PortKind::kLink,
             .token = ++token_,
             .name = "robot3",
             .link = {.kind = LinkKind::kPeer, .role = Role::kSystem, .system = 3},
             .subject = *policy::Subject::parse("router:robot3, system:3, role:system")});
  const Header move = header(kMove, kChassis, Address(0x03180000));
  const policy::RuleText own{.name = "own", .from = "own", .then = "allow"};
  set({own, {.name = "nobody", .types = "commands", .then = "deny"}});
  EXPECT_EQ(send(peer, move), Outcome::kDelivered);
  set({own,
       {.name = "no robot drives another", .from = "role:system", .types = "drive", .then = "deny"},
       {.name = "rest", .then = "allow"}});
  EXPECT_EQ(send(peer, move), Outcome::kDenied);
  EXPECT_EQ(sink_.replies.back().header.type, type::kNotAvailable);
  EXPECT_EQ(send(peer, header(type::kGetStatus, kChassis, Address(0x03180000))),
            Outcome::kDelivered);
}

// Questions to routers come over links like messages, and rules for routers name the rights.
TEST_F(RouterPolicyTest, ARobotThatMayLookDoesNotChangeOtherRouters) {
  set({{.name = "robots", .from = "role:system", .types = "change", .then = "deny"}});
  const ClientId peer = router_.connect(
      now_, {.port = PortKind::kLink,
             .token = ++token_,
             .name = "robot3",
             .link = {.kind = LinkKind::kPeer, .role = Role::kSystem, .system = 3},
             .subject = *policy::Subject::parse("router:robot3, system:3, role:system")});
  const Header question = header(type::kAdminRequest, kOwn, Address(0x03000100));
  EXPECT_EQ(send(peer, question), Outcome::kHandled);
  sink_.right = policy::Right::kChange;
  EXPECT_EQ(send(peer, question), Outcome::kDenied);
  EXPECT_EQ(sink_.denied.back(), "rule \"robots\" for router:robot3");
  EXPECT_EQ(send(peer, header(type::kAdminRequest, Address(), Address())),
            Outcome::kMalformedCommand)
      << "a link commands nothing";
}

// They had mappings of mailboxes: see io/local_port.
TEST_F(RouterPolicyTest, AReloadDisconnectsLocalProgramsThatAreJudgedFromNowOn) {
  const ClientId own = enter(PortKind::kLocal, "own", kChassis);
  const ClientId other = enter(PortKind::kLocal, "uid:1000", kTool);
  const ClientId remote = enter(PortKind::kTcp, "user:guest");
  set(guests_);
  ASSERT_EQ(sink_.closed.size(), 1U);
  EXPECT_EQ(sink_.closed.front().client, other);
  EXPECT_EQ(sink_.closed.front().reason, CloseReason::kJudged);
  EXPECT_NE(router_.client(own), nullptr);
  EXPECT_NE(router_.client(remote), nullptr);
  EXPECT_TRUE(router_.is_direct(*router_.find(kChassis)));
}

TEST_F(RouterPolicyTest, NobodyWritesToMailboxesOfAJudgedProgramDirectly) {
  set(guests_);
  enter(PortKind::kLocal, "own", kChassis);
  enter(PortKind::kLocal, "user:guest", kTool);
  EXPECT_TRUE(router_.is_direct(*router_.find(kChassis)));
  EXPECT_FALSE(router_.is_direct(*router_.find(kTool)));
}

TEST_F(RouterPolicyTest, ThinnedSamplesAreNoLosses) {
  set({{.name = "half", .from = "user:guest", .types = "-6", .then = "thin", .every = 2},
       {.name = "rest", .then = "allow"}});
  enter(PortKind::kLocal, "own", kChassis);
  const ClientId guest = enter(PortKind::kTcp, "user:guest", kTool);
  Header sample = header(type::kData, kChassis, kTool);
  sample.flags = flag::kStream;
  for (int i = 0; i < 10; ++i) (void)send(guest, sample);
  EXPECT_EQ(sink_.delivered.size(), 5U);
  EXPECT_EQ(count(PortKind::kTcp, Outcome::kThinned), 5U);
  EXPECT_EQ(report_status(router_, now_).drops, 0U);
}

TEST_F(RouterPolicyTest, ARouteNamesTheRuleThatDeniesIt) {
  set(guests_);
  enter(PortKind::kLocal, "own", kChassis);
  enter(PortKind::kTcp, "user:guest", kTool);
  const RouteReport denied = report_route(router_, now_, kChassis, kMove, kTool);
  EXPECT_EQ(denied.verdict, RouteReport::Verdict::kDenied);
  EXPECT_TRUE(denied.not_available);
  EXPECT_EQ(denied.denied.subject, "user:guest");
  EXPECT_EQ(report_route(router_, now_, kChassis, type::kGetStatus, kTool).verdict,
            RouteReport::Verdict::kDeliver);
  EXPECT_EQ(report_route(router_, now_, kChassis, kMove).verdict, RouteReport::Verdict::kDeliver);
}

// What a robot may ask of this router, and of others through it.
TEST_F(RouterPolicyTest, ARouteNamesTheRuleThatKeepsAnotherRobotFromChanges) {
  constexpr Address kOfRobot{0x03180000};
  constexpr Address kAgentOfOther{0x05000101};
  const ClientId robot = router_.connect(
      now_, {.port = PortKind::kLink,
             .token = ++token_,
             .name = "robot3",
             .link = {.kind = LinkKind::kSub, .role = Role::kSystem, .system = 3},
             .subject = *policy::Subject::parse("router:robot3, system:3, other-robot")});
  ASSERT_TRUE(router_.learn(now_, robot, kOfRobot, {.router = Address(0x03000100), .hops = 1}));
  const auto verdict = [&](Address to, policy::Right right) {
    return report_route(router_, now_, to, type::kAdminRequest, kOfRobot, right);
  };
  for (const Address to : {kOwn, kAgentOfOther}) {
    const RouteReport denied = verdict(to, policy::Right::kChange);
    EXPECT_EQ(denied.verdict, RouteReport::Verdict::kDenied);
    EXPECT_EQ(denied.denied.rule.name, "(other robots)");
    EXPECT_NE(verdict(to, policy::Right::kLook).verdict, RouteReport::Verdict::kDenied);
    EXPECT_NE(verdict(to, policy::Right::kAgree).verdict, RouteReport::Verdict::kDenied);
  }
}

TEST_F(RouterPolicyTest, TheAuditLogKeepsDenialsWhateverRegisters) {
  set(guests_);
  enter(PortKind::kLocal, "own", kChassis);
  const ClientId guest = enter(PortKind::kTcp, "user:guest", kTool);
  (void)send(guest, header(kMove, kChassis, kTool));
  for (std::size_t i = 0; i < EventLog::kCapacity; ++i)
    router_.disconnect(now_, connect(), CloseReason::kPeerClosed);
  const EventPage audit = report_events(router_.audit(), 0, 100);
  ASSERT_EQ(audit.items.size(), 2U);
  EXPECT_EQ(audit.items[0].kind, EventKind::kPolicyChanged);
  EXPECT_EQ(audit.items[1].kind, EventKind::kDenied);
}

}  // namespace router_policy_test
}  // namespace tims::core::test
