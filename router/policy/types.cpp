#include "router/policy/types.h"

#include <algorithm>
#include <array>

#include "base/text.h"
#include "router/policy/type_names.h"

namespace tims::policy {
namespace {

constexpr std::array<std::string_view, 9> kWords{"*",      "commands", "replies", "look", "drive",
                                                 "change", "agree",    "login",   "trace"};

constexpr std::uint8_t bit(Right right) {
  return static_cast<std::uint8_t>(1U << static_cast<unsigned>(right));
}

// What reads and changes nothing.
constexpr std::array<std::int8_t, 10> kLooks{
    type::kGetStatus,   type::kGetData,     type::kGetContData,    type::kStopContData,
    type::kGetNextData, type::kGetParam,    type::kGetDescription, type::kGetParamEffects,
    type::kGetRuntime,  type::kGetListeners};

// What moves a robot (core/driving_leases.h), and what stops it.
constexpr std::array<std::string_view, 9> kDrives{"chassis.move",
                                                  "chassis.set_active_pilot",
                                                  "pilot.set_destination",
                                                  "pilot.hold_command",
                                                  "pilot.set_multi_destination",
                                                  "path.make",
                                                  "path.set_destination",
                                                  "path.set_rddf",
                                                  "vehicle.set_value"};

std::string full_name(const TypeName& name) {
  return name.class_id == kEveryClass ? std::string(name.name)
                                      : std::string(name.class_name) + "." + std::string(name.name);
}

// "chassis.move"; a name without a class is one that every class has, or of any class that has it.
std::vector<const TypeName*> named(std::string_view text) {
  std::vector<const TypeName*> found;
  for (const TypeName& name : kTypeNames)
    if (full_name(name) == text || (text.find('.') == std::string_view::npos && name.name == text))
      found.push_back(&name);
  return found;
}

std::optional<std::int8_t> number(std::string_view text) {
  return base::parse_number<std::int8_t>(text);
}

}  // namespace

std::string TypePattern::problem(std::string_view text) {
  if (parse(text)) return {};
  std::string what = "\"" + std::string(text) + "\" is no type of messages";
  std::vector<std::string> known(kWords.begin(), kWords.end());
  for (const TypeName& name : kTypeNames) {
    known.push_back(full_name(name));
    known.emplace_back(name.name);
  }
  if (const auto near = base::nearest(base::lower(text), known))
    return what + "; did you mean \"" + std::string(*near) + "\"?";
  return what +
         ": write \"commands\", \"replies\", \"look\", \"drive\", \"change\", \"agree\", "
         "\"login\", "
         "\"trace\", a name such as \"chassis.move\" (timsctl msg types), or numbers such "
         "as \"21\" or \"20..29\"";
}

std::optional<TypePattern> TypePattern::parse(std::string_view given) {
  const std::string text = base::lower(given);
  TypePattern pattern;
  const auto add = [&](std::uint16_t class_id, std::int8_t first, std::int8_t last) {
    pattern.spans_.push_back({class_id, first, last});
  };
  if (text == "*") {
    add(kEveryClass, -128, 127);
    pattern.rights_ = kAllRights;
  } else if (text == "commands") {
    add(kEveryClass, 1, 127);
  } else if (text == "replies") {
    add(kEveryClass, -128, 0);
  } else if (text == "look") {
    for (const std::int8_t type : kLooks) add(kEveryClass, type, type);
    pattern.rights_ = bit(Right::kLook);
  } else if (text == "drive") {
    for (const TypeName& name : kTypeNames)
      if (std::ranges::find(kDrives, full_name(name)) != kDrives.end())
        add(name.class_id, name.type, name.type);
    add(class_id::kJoystick, type::kData, type::kData);
    pattern.rights_ = bit(Right::kDrive);
  } else if (text == "change") {
    pattern.rights_ = bit(Right::kChange) | bit(Right::kAgree);
  } else if (text == "agree") {
    pattern.rights_ = bit(Right::kAgree);
  } else if (text == "login") {
    pattern.rights_ = bit(Right::kLogin);
  } else if (text == "trace") {
    pattern.rights_ = bit(Right::kTrace);
  } else if (const std::size_t dots = text.find(".."); dots != std::string::npos) {
    const auto first = number(std::string_view(text).substr(0, dots));
    const auto last = number(std::string_view(text).substr(dots + 2));
    if (!first || !last || *first > *last) return std::nullopt;
    add(kEveryClass, *first, *last);
  } else if (const auto type = number(text)) {
    add(kEveryClass, *type, *type);
  } else {
    for (const TypeName* name : named(text)) add(name->class_id, name->type, name->type);
    if (pattern.spans_.empty()) return std::nullopt;
  }
  return pattern;
}

bool TypePattern::matches(const Query& query, std::uint16_t class_id) const {
  if (query.right != Right::kNone) return (rights_ & bit(query.right)) != 0;
  return std::ranges::any_of(spans_, [&](const Span& span) {
    return span.first <= query.type && query.type <= span.last &&
           (span.class_id == kEveryClass || span.class_id == class_id);
  });
}

bool TypePattern::covers(const TypePattern& other) const {
  if ((rights_ & other.rights_) != other.rights_) return false;
  return std::ranges::all_of(other.spans_, [&](const Span& its) {
    return std::ranges::any_of(spans_, [&](const Span& span) {
      return span.first <= its.first && its.last <= span.last &&
             (span.class_id == kEveryClass || span.class_id == its.class_id);
    });
  });
}

std::optional<Query> parse_type(std::string_view given, std::uint16_t class_id) {
  const std::string text = base::lower(given);
  if (const auto type = number(text)) return Query{.type = *type};
  const auto right = [](Right r) { return Query{.type = type::kAdminRequest, .right = r}; };
  if (text == "look") return right(Right::kLook);
  if (text == "change") return right(Right::kChange);
  if (text == "agree") return right(Right::kAgree);
  if (text == "login") return right(Right::kLogin);
  std::vector<const TypeName*> found = named(text);
  if (found.size() > 1)
    std::erase_if(found, [&](const TypeName* name) {
      return name->class_id != class_id && name->class_id != kEveryClass;
    });
  if (found.empty()) return std::nullopt;
  return Query{.type = found.front()->type};
}

}  // namespace tims::policy
