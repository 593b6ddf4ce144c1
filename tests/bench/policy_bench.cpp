#include "tests/bench/policy_bench.h"

#include <string>
#include <vector>

#include "os/clock.h"
#include "router/policy/enforcer.h"
#include "tests/bench/metrics.h"
#include "tests/bench/rules.h"

namespace tims::bench {

bool measure_verdicts(const Plan& plan) {
  constexpr std::uint32_t kBytes = 80;
  std::vector<policy::RuleText> rules;
  for (std::size_t i = 0; i < kRules; ++i) rules.push_back(nth_rule(i));
  std::vector<policy::Problem> problems;
  auto policy = policy::Policy::compile({.rules = rules}, {}, problems);
  if (!policy) return false;
  policy::Enforcer enforcer(std::move(*policy), 1);
  policy::Profile& profile = enforcer.enter(os::now(), *policy::Subject::parse("port:tcp"));
  std::vector<policy::Query> queries;
  for (std::uint32_t i = 0; i < plan.count; ++i)
    queries.push_back({.dest = Address(0x00140000 + (i << 8)), .src = Address(1), .type = 21});
  const auto all = [&](Time now) {
    std::uint64_t passed = 0;
    for (const policy::Query& query : queries)
      passed += enforcer.judge(now, profile, query, 1, kBytes).what == policy::Verdict::What::kPass
                    ? 1
                    : 0;
    return passed;
  };
  const Time start = os::now();
  if (all(start) != queries.size()) return false;  // also fills the cache
  std::uint64_t verdicts = 0;
  Time now = start;
  for (; now < start + plan.seconds; now = os::now()) verdicts += all(now);
  print_metric("verdict_ns",
               static_cast<double>((now - start).count()) / static_cast<double>(verdicts));
  return true;
}

}  // namespace tims::bench
