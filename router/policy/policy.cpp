#include "router/policy/policy.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "base/text.h"

namespace tims::policy {
namespace {

constexpr std::array<std::string_view, 4> kActions{"allow", "deny", "observe", "thin"};

std::vector<std::string> items_of(std::string_view text) {
  std::vector<std::string> items;
  while (!text.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    if (const auto item = base::trimmed(text.substr(0, comma)); !item.empty())
      items.emplace_back(item);
    text.remove_prefix(std::min(text.size(), comma + 1));
  }
  return items;
}

// The two words of a pattern: the bits that must match, and their values.
struct PatternBits {
  std::uint32_t mask = 0;
  std::uint32_t value = 0;
};
static_assert(sizeof(PatternBits) == sizeof(AddressPattern));

bool covers(const AddressPattern& wide, const AddressPattern& narrow) {
  const auto a = std::bit_cast<PatternBits>(wide);
  const auto b = std::bit_cast<PatternBits>(narrow);
  return (a.mask & b.mask) == a.mask && (b.value & a.mask) == a.value;
}
bool covers(const SubjectPattern& wide, const SubjectPattern& narrow) {
  return wide.covers(narrow);
}
bool covers(const TypePattern& wide, const TypePattern& narrow) { return wide.covers(narrow); }

// Each of the narrow ones is covered by one of the wide ones.
template <typename Pattern>
bool all_covered(const std::vector<Pattern>& wide, const std::vector<Pattern>& narrow) {
  return std::ranges::all_of(narrow, [&](const Pattern& n) {
    return std::ranges::any_of(wide, [&](const Pattern& w) { return covers(w, n); });
  });
}

bool hides(const Rule& earlier, const Rule& later) {
  const bool thins = earlier.action == Action::kThin;
  return thins == (later.action == Action::kThin) && all_covered(earlier.from, later.from) &&
         all_covered(earlier.to, later.to) && all_covered(earlier.types, later.types);
}

// Compiles rules and tests, and collects what is wrong with them.
class Compiler {
 public:
  Compiler(const PolicyText& text, const AddressWidths& widths, std::vector<Problem>& problems)
      : text_(text), widths_(widths), problems_(problems) {}

  std::vector<Rule> rules() {
    std::vector<Rule> rules;
    if (text_.rules.size() > kRulesMax)
      fail(kRulesMax, {}, "there are more than " + std::to_string(kRulesMax) + " rules");
    for (index_ = 0; index_ < std::min(text_.rules.size(), kRulesMax); ++index_)
      rules.push_back(compile(text_.rules[index_]));
    if (problems_.empty()) find_hidden(rules);
    return rules;
  }

 private:
  Rule compile(const RuleText& text) {
    Rule rule{.text = text};
    if (text.name.empty())
      fail(index_, "name", "a rule needs a name: write name = \"guests look\"");
    if (text.name.starts_with('('))
      fail(index_, "name", "names in parentheses are those of built-in rules: write another");
    const auto same = std::ranges::find(text_.rules, text.name, &RuleText::name);
    if (!text.name.empty() && same - text_.rules.begin() < std::ptrdiff_t(index_))
      fail(index_, "name",
           "the name " + base::in_quotes(text.name) + " is already that of the rule at " +
               same->place);
    read_action(rule);
    read_list(text.from, "from", rule.from, SubjectPattern::problem, SubjectPattern::parse);
    read_list(
        text.to, "to", rule.to, [&](std::string_view item) { return problem_of_address(item); },
        [&](std::string_view item) { return AddressPattern::parse(item, widths_); });
    read_list(text.types, "types", rule.types, TypePattern::problem, TypePattern::parse);
    return rule;
  }

  void read_action(Rule& rule) {
    const auto found = std::ranges::find(kActions, rule.text.then);
    if (found != kActions.end()) {
      rule.action = static_cast<Action>(found - kActions.begin());
    } else {
      std::string what = rule.text.then.empty()
                             ? "a rule needs an action: write then = \"allow\", \"deny\", "
                               "\"observe\" or \"thin\""
                             : base::in_quotes(rule.text.then) +
                                   " is no action: write allow, deny, observe or thin";
      if (const auto near = base::nearest(rule.text.then, std::span(kActions)))
        what = base::in_quotes(rule.text.then) + " is no action; did you mean \"" +
               std::string(*near) + "\"?";
      return fail(index_, "then", what);
    }
    const RuleText& text = rule.text;
    const bool has_limit = text.per_second != 0 || text.every != 0 || text.bytes_max != 0;
    const bool lowers = text.priority_max != 255;
    if (rule.action == Action::kThin && !has_limit && !lowers)
      fail(index_, "then", "thin needs per_second, every, bytes_max or priority_max");
    if (rule.action != Action::kThin && has_limit)
      fail(index_, "then", "per_second, every and bytes_max belong to then = \"thin\"");
    if (rule.action == Action::kDeny && (lowers || text.rate != 0))
      fail(index_, "then", "deny has neither priority_max nor rate: remove them, or write allow");
  }

  std::string problem_of_address(std::string_view item) const {
    if (AddressPattern::parse(item, widths_)) return {};
    const std::string why = Address::problem(item, widths_);
    return base::in_quotes(item) +
           (why.empty() ? " is no pattern of addresses: write \"Ladar(3/*)\", \"*(3/*)\" or \"*\""
                        : ": " + why);
  }

  template <typename Pattern, typename ProblemOf, typename Parse>
  void read_list(const std::string& text, std::string_view key, std::vector<Pattern>& to,
                 ProblemOf problem_of, Parse parse) {
    const auto items = items_of(text);
    if (items.empty())
      fail(index_, key,
           std::string(key) + " is empty and would match nothing: remove it for \"*\"");
    for (const std::string& item : items) {
      if (const std::string problem = problem_of(item); !problem.empty())
        fail(index_, key, std::string(key) + ": " + problem);
      else
        to.push_back(*parse(item));
    }
  }

  void find_hidden(const std::vector<Rule>& rules) {
    for (std::size_t i = 0; i < rules.size(); ++i) {
      const auto earlier =
          std::find_if(rules.begin(), rules.begin() + static_cast<std::ptrdiff_t>(i),
                       [&](const Rule& rule) { return hides(rule, rules[i]); });
      if (earlier == rules.begin() + static_cast<std::ptrdiff_t>(i)) continue;
      fail(i, {},
           "the rule " + base::in_quotes(rules[i].text.name) + " can never match: the rule " +
               base::in_quotes(earlier->text.name) + " at " + earlier->text.place +
               " matches all of it before. Move it up, or remove it");
    }
  }

  void fail(std::size_t index, std::string_view key, std::string text) {
    problems_.push_back({.index = index, .key = key, .text = std::move(text)});
  }

  const PolicyText& text_;
  const AddressWidths& widths_;
  std::vector<Problem>& problems_;
  std::size_t index_ = 0;
};

// Runs one [[test]]; returns its problem: the key, and the text.
std::pair<std::string_view, std::string> run(const TestText& test, const Policy& policy) {
  const auto subject = Subject::parse(test.from);
  if (!subject)
    return {"from", "from " + base::in_quotes(test.from) +
                        R"( is no subject: write "user:guest", "uid:1000, gid:100" or "own")"};
  const auto to = Address::parse(test.to, policy.widths());
  if (!to)
    return {"to", "to " + base::in_quotes(test.to) + " is no address: write \"Chassis(3/0)\""};
  const auto class_id = static_cast<std::uint16_t>(to->fields(policy.widths()).class_id);
  auto query = parse_type(test.type, class_id);
  if (!query) return {"type", "type: " + TypePattern::problem(test.type)};
  if (test.expect != "allow" && test.expect != "deny" && test.expect != "observe")
    return {"expect",
            R"(expect must be "allow", "deny" or "observe", not )" + base::in_quotes(test.expect)};
  query->dest = *to;
  const Rule& rule = policy.rule(policy.decide(*subject, *query));
  const bool lowers = rule.action == Action::kAllow && test.priority > rule.text.priority_max;
  const std::string_view found = rule.action == Action::kThin ? "allow" : name(rule.action);
  if (found == test.expect) return {};
  return {"expect", "the test " + base::in_quotes(test.name) + " fails: the rule " +
                        base::in_quotes(rule.text.name) +
                        (rule.text.place.empty() ? "" : " at " + rule.text.place) + " says " +
                        std::string(found) + ", not " + test.expect +
                        (lowers ? " (at a lower priority)" : "")};
}

RuleText built_in(std::string name, std::string from, std::string types, std::string then) {
  return {.name = std::move(name),
          .from = std::move(from),
          .types = std::move(types),
          .then = std::move(then)};
}

// Built-in rules are correct.
Rule compiled(const RuleText& text) {
  Rule rule{.text = text};
  rule.action = static_cast<Action>(std::ranges::find(kActions, text.then) - kActions.begin());
  for (const std::string& item : items_of(text.from))
    rule.from.push_back(*SubjectPattern::parse(item));
  rule.to.emplace_back();
  for (const std::string& item : items_of(text.types))
    rule.types.push_back(*TypePattern::parse(item));
  return rule;
}

}  // namespace

std::string_view name(Action action) { return kActions[static_cast<std::size_t>(action)]; }

std::string RuleText::title() const {
  return "rule " + base::in_quotes(name) + (place.empty() ? "" : " at " + place);
}

bool Rule::is_for(const Subject& subject) const {
  return std::ranges::any_of(
      from, [&](const SubjectPattern& pattern) { return pattern.matches(subject); });
}

bool Rule::matches(const Query& query, const AddressWidths& widths) const {
  if (action == Action::kThin && !query.is_sample) return false;
  const std::uint16_t class_id = query.class_id(widths);
  return std::ranges::any_of(to,
                             [&](const auto& pattern) { return pattern.matches(query.dest); }) &&
         std::ranges::any_of(types,
                             [&](const auto& type) { return type.matches(query, class_id); });
}

bool Rule::lets_all_pass() const {
  return action == Action::kAllow && text.priority_max == 255 && text.rate == 0 &&
         std::ranges::any_of(to, [](const auto& pattern) { return covers(pattern, {}); }) &&
         std::ranges::any_of(types, [](const auto& type) { return type.is_everything(); });
}

Policy::Policy(AddressWidths widths) : widths_(widths) {
  add(compiled(built_in("(agents)", "other-robot", "agree", "allow")));
  add(compiled(built_in("(other robots)", "other-robot", "change", "deny")));
  add(compiled(built_in("(fleet)", "port:link", "*", "allow")));
  add(compiled(built_in("(none)", "*, port:link", "*", "deny")));
}

std::optional<Policy> Policy::compile(const PolicyText& text, const AddressWidths& widths,
                                      std::vector<Problem>& problems) {
  Policy policy(widths);
  std::vector<Rule> rules = Compiler(text, widths, problems).rules();
  if (!problems.empty()) return std::nullopt;
  if (rules.empty()) rules.push_back(compiled(built_in("(open)", "*", "*", "allow")));
  policy.rules_.insert(policy.rules_.begin(), rules.begin(), rules.end());
  for (std::size_t i = 0; i < text.tests.size(); ++i) {
    auto [key, problem] = run(text.tests[i], policy);
    if (!problem.empty()) problems.push_back({true, i, key, std::move(problem)});
  }
  return problems.empty() ? std::optional(std::move(policy)) : std::nullopt;
}

std::vector<RuleNumber> Policy::rules_for(const Subject& subject) const {
  std::vector<RuleNumber> numbers;
  for (std::size_t i = 0; i < rules_.size(); ++i)
    if (rules_[i].is_for(subject)) numbers.push_back(static_cast<RuleNumber>(i));
  return numbers;
}

RuleNumber Policy::decide(const std::vector<RuleNumber>& rules, const Query& query) const {
  if (query.is_sample) {
    for (const RuleNumber number : rules)
      if (rules_[number].action == Action::kThin && rules_[number].matches(query, widths_))
        return number;
  }
  for (const RuleNumber number : rules)
    if (rules_[number].action != Action::kThin && rules_[number].matches(query, widths_))
      return number;
  return static_cast<RuleNumber>(rules_.size() - 1);
}

}  // namespace tims::policy
