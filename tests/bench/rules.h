// The rules of a router's policy in measurements: many that match nothing there, then one that lets
// all pass.
#pragma once

#include <cstddef>
#include <string>

#include "router/policy/policy.h"

namespace tims::bench {

inline constexpr std::size_t kRules = 100;

inline policy::RuleText nth_rule(std::size_t i) {
  if (i + 1 == kRules) return {.name = "rest", .then = "allow"};
  return {.name = "rule " + std::to_string(i),
          .from = "port:tcp",
          .to = "Chassis(" + std::to_string(1 + i) + "/*)",
          .types = "commands",
          .then = "deny"};
}

// As a setting of tims-router.
inline std::string rule_setting(std::size_t i) {
  const policy::RuleText rule = nth_rule(i);
  return "rule=name=" + rule.name + ",from=" + rule.from + ",to=" + rule.to +
         ",types=" + rule.types + ",then=" + rule.then;
}

}  // namespace tims::bench
