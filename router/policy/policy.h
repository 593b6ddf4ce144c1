// The policy of a router: ordered rules, of which the first that matches a message decides.
//
// A rule says from whom (SubjectPattern), to which addresses, which types (TypePattern) it is
// about, and what happens: allow, deny, observe (let pass, and report what deny would have stopped)
// or thin (let only some samples of a stream pass). Samples are looked at by thin rules first, and
// only by them if one matches. Once there is any rule, what matches none is denied; without rules
// everything passes. Routers at the other ends of links are met only by
// rules that name routers, systems or roles: their messages were judged where they entered the
// fleet. The built-in ones among these come last: at a router with keys, those of other robots
// change nothing from below or beside; all else passes.
//
// Replies (types <= 0) to who has asked within the last minute need no rule (Enforcer).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "router/policy/subject.h"
#include "router/policy/types.h"
#include "tims/address.h"

namespace tims::policy {

enum class Action : std::uint8_t { kAllow, kDeny, kObserve, kThin };
std::string_view name(Action action);  // "allow"

// A rule as it is written: lists are separated by commas.
struct RuleText {
  std::string name{};
  std::string from = "*";
  std::string to = "*";
  std::string types = "*";
  std::uint8_t priority_max = 255;  // a higher priority is lowered to it
  std::uint64_t rate = 0;           // bytes a second of each subject; 0: no limit
  std::string then{};               // allow, deny, observe, thin
  // Of thin: at most so many samples a second, every n-th, none longer than so many bytes (header
  // included); 0: no limit.
  std::uint32_t per_second = 0;
  std::uint32_t every = 0;
  std::uint32_t bytes_max = 0;
  std::string place{};  // "router.toml:12"; empty: built in

  [[nodiscard]] std::string title() const;  // rule "guests" at router.toml:12
  bool operator==(const RuleText&) const = default;
};

// A message and what shall become of it: [[test]].
struct TestText {
  std::string name;
  std::string from;  // "user:guest", or several identities: "uid:1000, gid:100"
  std::string to;    // an address
  std::string type;
  std::uint8_t priority = 0;
  std::string expect;  // allow, deny, observe
  bool operator==(const TestText&) const = default;
};

struct PolicyText {
  std::vector<RuleText> rules{};
  std::vector<TestText> tests{};
  bool operator==(const PolicyText&) const = default;
};

// What is wrong with a rule or a test.
struct Problem {
  bool is_test = false;
  std::size_t index = 0;
  std::string_view key{};  // "types"; empty: the whole item
  std::string text{};
};

struct Rule {
  RuleText text{};
  Action action = Action::kDeny;
  std::vector<SubjectPattern> from{};
  std::vector<AddressPattern> to{};
  std::vector<TypePattern> types{};

  [[nodiscard]] bool is_for(const Subject& subject) const;
  [[nodiscard]] bool matches(const Query& query, const AddressWidths& widths) const;
  // An allow rule without any condition: everything passes.
  [[nodiscard]] bool lets_all_pass() const;
};

// The number of a rule; the last one of every policy is "(none)", which denies.
using RuleNumber = std::uint16_t;
inline constexpr std::size_t kRulesMax = 10'000;

class Policy {
 public:
  // Denies everything.
  explicit Policy(AddressWidths widths = {});
  // The configured rules and tests; with problems, nothing. Without rules, everything passes.
  static std::optional<Policy> compile(const PolicyText& text, const AddressWidths& widths,
                                       std::vector<Problem>& problems);

  [[nodiscard]] const std::vector<Rule>& rules() const { return rules_; }
  [[nodiscard]] const Rule& rule(RuleNumber number) const { return rules_[number]; }
  [[nodiscard]] const AddressWidths& widths() const { return widths_; }
  // The rules that can apply to a subject, in order; the last is (none).
  [[nodiscard]] std::vector<RuleNumber> rules_for(const Subject& subject) const;
  // The first of these that matches.
  [[nodiscard]] RuleNumber decide(const std::vector<RuleNumber>& rules, const Query& query) const;
  [[nodiscard]] RuleNumber decide(const Subject& subject, const Query& query) const {
    return decide(rules_for(subject), query);
  }

 private:
  void add(Rule rule) { rules_.push_back(std::move(rule)); }

  AddressWidths widths_;
  std::vector<Rule> rules_;
};

}  // namespace tims::policy
