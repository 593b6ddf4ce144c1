#include "router/policy/policy.h"

#include <random>

#include <gtest/gtest.h>

namespace tims::policy::policy_test {

using std::string;

std::vector<Problem> problems_of(const PolicyText& text, const AddressWidths& widths = {}) {
  std::vector<Problem> problems;
  (void)Policy::compile(text, widths, problems);
  return problems;
}
Policy compiled(const PolicyText& text, const AddressWidths& widths = {}) {
  std::vector<Problem> problems;
  auto policy = Policy::compile(text, widths, problems);
  for (const Problem& problem : problems) ADD_FAILURE() << problem.text;
  return policy.value_or(Policy());
}
string rule_for(const Policy& policy, std::string_view from, std::string_view to,
                std::string_view type) {
  const Address dest = *Address::parse(to);
  Query query = *parse_type(type, static_cast<std::uint16_t>(dest.fields().class_id));
  query.dest = dest;
  return policy.rule(policy.decide(*Subject::parse(from), query)).text.name;
}
string first_problem(const PolicyText& text) {
  const auto problems = problems_of(text);
  return problems.empty() ? "" : problems.front().text;
}
string problem_of(RuleText rule) {
  if (rule.name.empty()) rule.name = "r";
  return first_problem({.rules = {std::move(rule)}});
}

TEST(Policy, WithoutRulesEverythingPasses) {
  const Policy policy = compiled({});
  EXPECT_EQ(rule_for(policy, "own", "Chassis(3/0)", "move"), "(open)");
  EXPECT_EQ(rule_for(policy, "uid:1000", "Tims(3/1)", "change"), "(open)");
  EXPECT_EQ(rule_for(policy, "user:kim, right:look", "Tims(3/1)", "login"), "(open)");
  EXPECT_EQ(rule_for(policy, "router:base", "Chassis(3/0)", "move"), "(fleet)");
  for (const std::string_view from : {"own", "uid:1000", "user:kim", "router:base"})
    EXPECT_TRUE(policy.rule(policy.rules_for(*Subject::parse(from)).front()).lets_all_pass());
}

TEST(Policy, RoutersOfOtherRobotsChangeNothingUnlessARuleSaysSo) {
  constexpr std::string_view kRobot = "router:r3, system:3, other-robot";
  const Policy open = compiled({});
  EXPECT_EQ(rule_for(open, kRobot, "Tims(5/1)", "change"), "(other robots)");
  EXPECT_EQ(rule_for(open, kRobot, "Tims(5/1):1", "agree"), "(agents)");
  for (const std::string_view type : {"look", "move", "login"})
    EXPECT_EQ(rule_for(open, kRobot, "Tims(5/1)", type), "(fleet)");
  EXPECT_EQ(rule_for(open, "router:r3, system:3", "Tims(5/1)", "change"), "(fleet)");
  const Policy ruled =
      compiled({.rules = {{.name = "ship", .from = "system:3", .types = "change", .then = "allow"},
                          {.name = "all", .then = "allow"}}});
  EXPECT_EQ(rule_for(ruled, kRobot, "Tims(5/1)", "change"), "ship");
  EXPECT_EQ(rule_for(ruled, kRobot, "Tims(5/1):1", "agree"), "ship") << "it is part of a change";
  EXPECT_EQ(rule_for(ruled, "router:r4, system:4, other-robot", "Tims(5/1)", "change"),
            "(other robots)")
      << "a rule for everybody is not one for routers";
  const Policy all =
      compiled({.rules = {{.name = "all robots", .from = "other-robot", .then = "allow"}}});
  EXPECT_EQ(rule_for(all, kRobot, "Tims(5/1)", "change"), "all robots");
}

TEST(Policy, TheFirstRuleThatMatchesDecides) {
  const Policy policy =
      compiled({.rules = {{.name = "stop", .from = "user:guest", .types = "off", .then = "allow"},
                          {.name = "no driving",
                           .from = "user:*",
                           .to = "Chassis(*/*), Pilot(*/*)",
                           .types = "commands",
                           .then = "deny"},
                          {.name = "rest", .from = "user:*", .then = "allow"}}});
  EXPECT_EQ(rule_for(policy, "user:guest", "Chassis(3/0)", "off"), "stop");
  EXPECT_EQ(rule_for(policy, "user:kim", "Chassis(3/0)", "off"), "no driving");
  EXPECT_EQ(rule_for(policy, "user:kim", "Chassis(3/0):2", "move"), "no driving");
  EXPECT_EQ(rule_for(policy, "user:kim", "Ladar(3/0)", "on"), "rest");
  EXPECT_EQ(rule_for(policy, "uid:0, own", "Ladar(3/0)", "on"), "(none)");
  EXPECT_EQ(rule_for(policy, "router:r3", "Ladar(3/0)", "on"), "(fleet)");
}

TEST(Policy, TypesOfAClassAreThoseOfTheReceiver) {
  const Policy policy =
      compiled({.rules = {{.name = "move", .types = "chassis.move", .then = "allow"},
                          {.name = "some", .types = "20..23, -6", .then = "allow"}}});
  EXPECT_EQ(rule_for(policy, "uid:1", "Chassis(3/0)", "21"), "move");
  EXPECT_EQ(rule_for(policy, "uid:1", "Pilot(3/0)", "21"), "some");
  EXPECT_EQ(rule_for(policy, "uid:1", "Pilot(3/0)", "24"), "(none)");
  EXPECT_EQ(rule_for(policy, "uid:1", "Pilot(3/0)", "-6"), "some");
  EXPECT_EQ(rule_for(policy, "uid:1", "Tims(3/1)", "change"), "(none)");
}

TEST(Policy, MistakesAreNamedWithWhatToWrite) {
  EXPECT_NE(problem_of({.then = "alow"}).find("did you mean \"allow\""), string::npos);
  EXPECT_NE(problem_of({}).find("needs an action"), string::npos);
  EXPECT_NE(problem_of({.from = " , ", .then = "deny"}).find("from is empty"), string::npos);
  EXPECT_NE(problem_of({.to = "Chasis(3/0)", .then = "deny"}).find("Chasis"), string::npos);
  EXPECT_NE(
      problem_of({.types = "chassis.mov", .then = "deny"}).find("did you mean \"chassis.move\""),
      string::npos);
  EXPECT_NE(problem_of({.then = "thin"}).find("thin needs"), string::npos);
  EXPECT_NE(problem_of({.then = "allow", .every = 2}).find("belong to"), string::npos);
  EXPECT_NE(problem_of({.rate = 5, .then = "deny"}).find("neither"), string::npos);
  EXPECT_NE(problem_of({.name = "(x)", .then = "deny"}).find("parentheses"), string::npos);
  EXPECT_EQ(problem_of({.priority_max = 3, .then = "thin"}), "");
}

TEST(Policy, AHiddenRuleNamesTheOneThatHidesIt) {
  const PolicyText text{
      .rules = {{.name = "all users", .from = "user:*", .then = "allow", .place = "a.toml:1"},
                {.name = "guest",
                 .from = "user:guest",
                 .to = "Chassis(3/*)",
                 .types = "on, off",
                 .then = "deny",
                 .place = "a.toml:5"}}};
  const auto problems = problems_of(text);
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_EQ(problems.front().index, 1U);
  EXPECT_NE(problems.front().text.find("\"all users\" at a.toml:1"), string::npos);
  PolicyText turned = text;
  std::swap(turned.rules[0], turned.rules[1]);
  EXPECT_TRUE(problems_of(turned).empty());
}

TEST(Policy, FailingTestsAreProblems) {
  PolicyText text{
      .rules = {{.name = "look", .from = "user:guest", .types = "look", .then = "allow"}},
      .tests = {{"a", "user:guest", "Chassis(3/0)", "get_status", 0, "allow"},
                {"b", "user:guest", "Chassis(3/0)", "move", 200, "deny"}}};
  EXPECT_TRUE(problems_of(text).empty());
  text.tests[1].expect = "allow";
  EXPECT_NE(first_problem(text).find("the test \"b\" fails: the rule \"(none)\" says deny"),
            string::npos);
  text.tests[1].type = "mve";
  EXPECT_NE(first_problem(text).find("did you mean"), string::npos);
  text.tests[1] = {"b", "guest", "Chassis(3/0)", "move", 200, "deny"};
  EXPECT_NE(first_problem(text).find("no subject"), string::npos);
}

// --- against an evaluator that is written as the documentation says, from the texts

bool naive_address(std::string_view pattern, const Address::Fields& at) {
  if (pattern == "*") return true;
  const auto open = pattern.find('(');
  const auto slash = pattern.find('/');
  const auto close = pattern.find(')');
  const auto field = [](std::string_view text, std::uint32_t value) {
    return text == "*" || text == std::to_string(value);
  };
  const std::string_view name = pattern.substr(0, open);
  return (name == "*" || class_id_of(name) == at.class_id) &&
         field(pattern.substr(open + 1, slash - open - 1), at.system) &&
         field(pattern.substr(slash + 1, close - slash - 1), at.instance);
}
bool naive_type(std::string_view types, const Query& q, std::uint32_t dest_class) {
  if (types == "*") return true;
  if (types == "commands") return q.type > 0;
  if (types == "replies") return q.type <= 0;
  if (types == "chassis.move") return q.type == 21 && dest_class == class_id::kChassis;
  if (types == "20..22") return q.type >= 20 && q.type <= 22;
  return std::to_string(q.type) == types;
}
bool naive_subject(std::string_view from, const Subject& subject) {
  return from == "*" || subject.has(from);
}

// In fleets of all kinds: whatever the widths, a pattern's fields are those of the address.
TEST(Policy, DecidesAsTheNaiveEvaluator) {
  std::mt19937 random(7);
  constexpr std::array kWidths{AddressWidths{}, AddressWidths{4, 6, 12, 10},
                               AddressWidths{16, 8, 4, 4}, AddressWidths{3, 26, 1, 2}};
  const auto pick = [&](const auto& list) { return list[random() % std::size(list)]; };
  constexpr std::array kFrom{"*", "uid:1", "uid:2", "user:a", "gid:5"};
  constexpr std::array kTo{"*", "Chassis(*/*)", "Chassis(3/0)", "*(3/*)", "Pilot(*/1)", "*(*/0)"};
  constexpr std::array kTypes{"*",      "commands", "replies", "chassis.move",
                              "20..22", "-6",       "21",      "0"};
  constexpr std::array kThen{"allow", "deny", "observe"};
  constexpr std::array kSubjects{"uid:1", "uid:2, gid:5", "user:a", "uid:3"};
  int rules_seen = 0;
  for (int round = 0; round < 800; ++round) {
    const AddressWidths& widths = pick(kWidths);
    PolicyText text;
    for (unsigned i = 0; i < 1 + random() % 12; ++i) {
      text.rules.push_back({.name = "r" + std::to_string(i),
                            .from = pick(kFrom),
                            .to = pick(kTo),
                            .types = pick(kTypes),
                            .then = pick(kThen)});
      if (!problems_of(text, widths).empty()) text.rules.pop_back();  // hidden
    }
    if (text.rules.empty()) continue;
    const Policy policy = compiled(text, widths);
    for (int i = 0; i < 50; ++i) {
      const Subject subject = *Subject::parse(pick(kSubjects));
      const std::array classes{class_id::kChassis, class_id::kPilot, class_id::kLadar};
      Query query{.dest = Address::of({.system = 3 + static_cast<unsigned>(random() % 2),
                                       .class_id = pick(classes),
                                       .instance = static_cast<unsigned>(random() % 2),
                                       .local = static_cast<unsigned>(random() % 2)},
                                      widths),
                  .type = static_cast<std::int8_t>(static_cast<int>(random() % 30) - 7)};
      const Address::Fields at = query.dest.fields(widths);
      std::size_t expected = policy.rules().size() - 1;  // (none)
      for (std::size_t n = text.rules.size(); n-- > 0;) {
        const RuleText& rule = text.rules[n];
        if (naive_subject(rule.from, subject) && naive_address(rule.to, at) &&
            naive_type(rule.types, query, at.class_id))
          expected = n;
      }
      ASSERT_EQ(policy.decide(subject, query), expected) << round;
      rules_seen += expected < text.rules.size() ? 1 : 0;
    }
  }
  EXPECT_GT(rules_seen, 5000);
}

}  // namespace tims::policy::policy_test
