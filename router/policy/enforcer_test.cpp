#include "router/policy/enforcer.h"

#include <array>

#include <gtest/gtest.h>

namespace tims::policy::enforcer_test {

using What = Verdict::What;

class EnforcerTest : public testing::Test {
 protected:
  static Policy compiled(std::vector<RuleText> rules) {
    std::vector<Problem> problems;
    auto policy = Policy::compile({.rules = std::move(rules)}, {}, problems);
    for (const Problem& problem : problems) ADD_FAILURE() << problem.text;
    return policy.value_or(Policy());
  }
  void set(std::vector<RuleText> rules) { enforcer_.set(now_, compiled(std::move(rules))); }
  Profile& enter(std::string_view subject) {
    return enforcer_.enter(now_, *Subject::parse(subject));
  }
  Verdict judge(Profile& profile, std::int8_t type, std::uint8_t priority = 10,
                std::uint32_t bytes = 100, bool is_sample = false) {
    return enforcer_.judge(now_, profile,
                           {.dest = kTo, .src = kFrom, .type = type, .is_sample = is_sample},
                           priority, bytes);
  }

  static constexpr Address kTo = Address::of({3, class_id::kChassis, 0, 0});
  static constexpr Address kFrom = Address::of({3, class_id::kTool, 7, 0});
  Time now_ = Time(std::chrono::seconds(1000));
  Enforcer enforcer_{compiled({}), 42};
};

TEST_F(EnforcerTest, WhoMayEverythingIsNotJudged) {
  EXPECT_TRUE(enter("uid:1").is_free());
  set({{.name = "own", .from = "own", .then = "allow"},
       {.name = "others", .types = "look", .then = "allow"}});
  EXPECT_TRUE(enter("own").is_free());
  EXPECT_FALSE(enter("uid:1").is_free());
  EXPECT_TRUE(enter("router:r1").is_free());
  EXPECT_FALSE(enter("router:r1, other-robot").is_free()) << "it changes no routers";
}

TEST_F(EnforcerTest, AVerdictIsTheSameFromTheCache) {
  set({{.name = "move", .types = "chassis.move", .priority_max = 50, .then = "allow"}});
  Profile& profile = enter("uid:1");
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(judge(profile, 21, 200).what, What::kPass);
    EXPECT_EQ(judge(profile, 21, 200).priority, 50);
    EXPECT_EQ(judge(profile, 21, 7).priority, 7);
    EXPECT_EQ(judge(profile, 22).what, What::kDenied);
  }
  EXPECT_EQ(enforcer_.hits(0).messages, 9U);
  EXPECT_EQ(enforcer_.hits(0).lowered, 6U);
  const std::size_t none = enforcer_.policy().rules().size() - 1;
  EXPECT_EQ(enforcer_.hits(static_cast<RuleNumber>(none)).denied, 3U);
}

TEST_F(EnforcerTest, AReloadAppliesToWhoIsConnectedAndKeepsCountersOfSameRules) {
  set({{.name = "move", .types = "chassis.move", .then = "allow"}});
  Profile& profile = enter("uid:1");
  EXPECT_EQ(judge(profile, 21).what, What::kPass);
  set({{.name = "off", .types = "off", .then = "allow"},
       {.name = "move", .types = "chassis.move", .then = "allow"}});
  EXPECT_EQ(enforcer_.hits(1).messages, 1U);
  EXPECT_EQ(judge(profile, 2).what, What::kPass);
  set({{.name = "no", .types = "commands", .then = "deny"}});
  EXPECT_EQ(judge(profile, 21).what, What::kDenied);
  set({});
  EXPECT_EQ(judge(profile, 3).what, What::kPass);
}

TEST_F(EnforcerTest, ARateIsSharedByAllConnectionsOfASubject) {
  set({{.name = "slow", .rate = 1000, .then = "allow"}});
  Profile& one = enter("uid:1, gid:1");
  Profile& two = enter("uid:1, gid:2");
  Profile& other = enter("uid:2");
  EXPECT_EQ(judge(one, 21, 0, 1000).what, What::kPass);
  EXPECT_EQ(judge(two, 21, 0, 16).what, What::kDenied);
  EXPECT_EQ(judge(other, 21, 0, 16).what, What::kPass);
  // A new connection does not fill the bucket.
  enforcer_.leave(now_, one);
  enforcer_.leave(now_, two);
  EXPECT_EQ(judge(enter("uid:1"), 21, 0, 16).what, What::kDenied);
  now_ += std::chrono::seconds(1);
  EXPECT_EQ(judge(enter("uid:1"), 21, 0, 16).what, What::kPass);
  EXPECT_EQ(enforcer_.hits(0).over_rate, 2U);
}

TEST_F(EnforcerTest, AnAnswerWithinAMinuteNeedsNoRule) {
  set({{.name = "no", .types = "99", .then = "allow"}});
  Profile& profile = enter("uid:1");
  EXPECT_EQ(judge(profile, 0).what, What::kDenied);
  enforcer_.asked(now_, kTo, kFrom);
  EXPECT_EQ(judge(profile, 0, 255).what, What::kPass);
  EXPECT_EQ(judge(profile, 0, 255).priority, Enforcer::kReplyPriorityMax);
  EXPECT_EQ(judge(profile, 21).what, What::kDenied);  // commands are no answers
  now_ += Conversations::kTime - Duration(1);
  EXPECT_EQ(judge(profile, 0).what, What::kPass);
  now_ += Duration(1);
  EXPECT_EQ(judge(profile, 0).what, What::kDenied);
  EXPECT_EQ(enforcer_.replies(), 3U);
}

TEST_F(EnforcerTest, SamplesKeepASubscriptionOpen) {
  set({{.name = "no", .types = "99", .then = "allow"}});
  Profile& profile = enter("uid:1");
  enforcer_.asked(now_, kTo, kFrom);
  for (int i = 0; i < 5; ++i) {
    now_ += std::chrono::seconds(50);
    EXPECT_EQ(judge(profile, -6, 0, 100, true).what, What::kPass);
  }
  now_ += std::chrono::seconds(61);
  EXPECT_EQ(judge(profile, -6, 0, 100, true).what, What::kDenied);
}

TEST_F(EnforcerTest, StreamsAreThinnedByCountRateSizeAndPriority) {
  set({{.name = "third", .types = "-6", .priority_max = 5, .then = "thin", .every = 3},
       {.name = "ten", .types = "-7", .then = "thin", .per_second = 10},
       {.name = "short", .types = "-8", .then = "thin", .bytes_max = 64}});
  Profile& profile = enter("uid:1");
  int third = 0;
  int ten = 0;
  for (int i = 0; i < 300; ++i) {
    const Verdict verdict = judge(profile, -6, 20, 100, true);
    third += verdict.what == What::kPass ? 1 : 0;
    EXPECT_EQ(verdict.what == What::kPass ? verdict.priority : 5, 5);
    ten += judge(profile, -7, 20, 100, true).what == What::kPass ? 1 : 0;
    now_ += std::chrono::milliseconds(10);
  }
  EXPECT_EQ(third, 100);
  EXPECT_NEAR(ten, 30, 1);
  EXPECT_EQ(judge(profile, -8, 0, 64, true).what, What::kPass);
  EXPECT_EQ(judge(profile, -8, 0, 65, true).what, What::kThinned);
  EXPECT_EQ(judge(profile, -8, 0, 64, false).what, What::kDenied);  // no sample: no thin rule
  EXPECT_EQ(enforcer_.hits(0).thinned, 200U);
}

TEST_F(EnforcerTest, TheFirstDenialIsReportedThenACountAMinute) {
  set({{.name = "no", .types = "commands", .then = "deny"}});
  Profile& profile = enter("uid:1");
  EXPECT_TRUE(judge(profile, 21).report);
  for (int i = 0; i < 9; ++i) EXPECT_FALSE(judge(profile, 21).report);
  EXPECT_EQ(enforcer_.next_report(), now_ + Enforcer::kReportEvery);
  now_ += Enforcer::kReportEvery;
  const auto reports = enforcer_.take_reports(now_);
  ASSERT_EQ(reports.size(), 1U);
  EXPECT_EQ(reports.front().rule, "no");
  EXPECT_EQ(reports.front().subject, "uid:1");
  EXPECT_EQ(reports.front().messages, 9U);
  EXPECT_TRUE(enforcer_.take_reports(now_).empty());
  EXPECT_EQ(enforcer_.next_report(), kNever);
  // What was counted is reported although its sender goes.
  (void)judge(profile, 21);
  enforcer_.leave(now_, profile);
  EXPECT_EQ(enforcer_.take_reports(now_ + Enforcer::kReportEvery).size(), 1U);
}

TEST_F(EnforcerTest, ObserveLetsPassAndReports) {
  set({{.name = "try", .types = "commands", .then = "observe"}});
  Profile& profile = enter("uid:1");
  EXPECT_TRUE(judge(profile, 21).report);
  EXPECT_EQ(judge(profile, 21).what, What::kPass);
}

// The cache returns what the policy decides, for many more keys than it has room for.
TEST_F(EnforcerTest, TheCacheDecidesAsThePolicy) {
  set({{.name = "a", .to = "*(3/*)", .types = "20..40", .then = "deny"},
       {.name = "b", .to = "Chassis(*/*)", .types = "commands", .then = "allow"},
       {.name = "c", .from = "uid:2", .types = "-6", .then = "allow"}});
  const std::array profiles{&enter("uid:1"), &enter("uid:2")};
  std::uint32_t seed = 1;
  for (int i = 0; i < 200'000; ++i) {
    seed = seed * 1664525 + 1013904223;
    Profile& profile = *profiles[seed >> 31];
    const Query query{
        .dest = Address::of({seed >> 8 & 7, 0x10 + (seed >> 12 & 3), seed >> 16 & 255, 0}),
        .src = kFrom,
        .type = static_cast<std::int8_t>(seed >> 24)};
    const Verdict verdict = enforcer_.judge(now_, profile, query, 0, 16);
    const Rule& rule = enforcer_.policy().rule(enforcer_.policy().decide(profile.rules(), query));
    ASSERT_EQ(verdict.what == What::kDenied, rule.action == Action::kDeny) << i;
  }
}

}  // namespace tims::policy::enforcer_test
