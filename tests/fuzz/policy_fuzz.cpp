// Rules of a configuration, and messages judged by them. A rule or test is refused with its place;
// or verdicts, from the cache and after a reload, are those of the first rule in the file that
// matches.
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "router/config/load.h"
#include "router/policy/enforcer.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace tims;

constexpr std::string_view kSubjects[] = {"own",
                                          "uid:1000, gid:100",
                                          "user:guest, right:look, net:10.9.1.7",
                                          "net:fe80::1, port:tcp",
                                          "unit:laser.service",
                                          "router:robot3, system:3, role:system"};

// As the documentation says it: from the first rule to the last.
policy::RuleNumber first_match(const policy::Policy& policy, const policy::Subject& subject,
                               const policy::Query& query) {
  std::optional<policy::RuleNumber> found;
  for (std::size_t i = policy.rules().size(); i-- > 0;) {
    const policy::Rule& rule = policy.rules()[i];
    const bool thins = rule.action == policy::Action::kThin;
    if (!rule.is_for(subject) || !rule.matches(query, policy.widths())) continue;
    const bool has_thin = found && policy.rule(*found).action == policy::Action::kThin;
    if (thins || !has_thin) found = static_cast<policy::RuleNumber>(i);
  }
  fuzz::require(found.has_value());  // (none) matches everybody
  return *found;
}

policy::Query query_of(fuzz::Input& input) {
  const auto bits = input.number<std::uint8_t>();
  return {.dest = Address(input.number<std::uint32_t>()),
          .src = Address(input.number<std::uint32_t>()),
          .type = input.number<std::int8_t>(),
          .is_sample = (bits & 1U) != 0,
          .right = static_cast<policy::Right>((bits >> 1U) % 6)};
}

void check(policy::Enforcer& enforcer, policy::Profile& profile, const policy::Query& query,
           Time now, std::uint8_t priority) {
  using What = policy::Verdict::What;
  const policy::Policy& policy = enforcer.policy();
  const policy::RuleNumber number = first_match(policy, profile.subject(), query);
  const policy::Rule& rule = policy.rule(number);
  for (int i = 0; i < 2; ++i) {
    const policy::Verdict verdict = enforcer.judge(now, profile, query, priority, 100);
    fuzz::require(verdict.rule == number && verdict.priority <= priority);
    if (rule.action == policy::Action::kDeny) fuzz::require(verdict.what == What::kDenied);
    if (verdict.what == What::kThinned) fuzz::require(rule.action == policy::Action::kThin);
    if (verdict.what == What::kPass) fuzz::require(verdict.priority <= rule.text.priority_max);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // The file, a zero byte, the messages.
  const auto* const end = std::find(data, data + size, std::uint8_t{0});
  fuzz::Input file(data, static_cast<std::size_t>(end - data));
  fuzz::Input messages(end, size - static_cast<std::size_t>(end - data));
  const config::Loaded loaded = config::load({{{"fuzz.toml", std::string(file.text())}},
                                              {},
                                              {.name = "robot1", .uid = 0, .environment = {}}});
  for (const config::Problem& problem : loaded.problems) fuzz::require(problem.at.line > 0);
  if (!loaded.ok()) return 0;
  std::vector<policy::Problem> problems;
  const auto text = config::policy_text(loaded.config, config::rule_places(loaded.origins));
  const AddressWidths& widths = loaded.config.address.widths;
  auto policy = policy::Policy::compile(text, widths, problems);
  fuzz::require(policy.has_value() && problems.empty());
  policy::Enforcer enforcer(policy::Policy(widths), 1);
  Time now = Time(std::chrono::seconds(100));
  std::vector<policy::Profile*> profiles;
  for (const std::string_view who : kSubjects)
    profiles.push_back(&enforcer.enter(now, *policy::Subject::parse(who)));
  enforcer.set(now, std::move(*policy));
  while (!messages.empty()) {
    policy::Profile& profile = *profiles[messages.number<std::uint8_t>() % std::size(kSubjects)];
    now += std::chrono::milliseconds(messages.number<std::uint8_t>());
    const auto priority = messages.number<std::uint8_t>();
    check(enforcer, profile, query_of(messages), now, priority);
  }
  fuzz::use(enforcer.take_reports(kNever));
  for (policy::Profile* profile : profiles) enforcer.leave(now, *profile);
  return 0;
}
