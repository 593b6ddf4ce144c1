#include "router/config/unknown.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "router/config/nearest.h"

namespace tims::config {
namespace {

// Nearest known key; else, for a name in the wrong table, the key that has exactly this name.
std::string did_you_mean(std::string_view key) {
  std::vector<std::string_view> known;
  for (const Option& option : options()) known.push_back(option.key);
  for (const List& list : lists()) known.push_back(list.name);
  if (const auto best = nearest(key, known)) return fmt::format("; did you mean {}?", *best);
  const std::string_view name = key.substr(key.rfind('.') + 1);
  std::string found;
  for (const Option& option : options())
    if (option.name() == name)
      found += fmt::format("{}{}", found.empty() ? "" : " or ", option.key);
  return found.empty() ? "" : fmt::format("; did you mean {}?", found);
}

std::string in_brackets(std::string_view name, bool is_list) {
  return fmt::format("{}{}{}", is_list ? "[[" : "[", name, is_list ? "]]" : "]");
}

std::vector<std::string_view> tables() {
  std::vector<std::string_view> known;
  for (const Option& option : options())
    if (known.empty() || known.back() != option.table()) known.push_back(option.table());
  for (const List& list : lists()) known.push_back(list.name);
  return known;
}

}  // namespace

bool is_table(std::string_view name) {
  return std::ranges::any_of(options(), [&](const Option& o) { return o.table() == name; });
}

std::string unknown_key(std::string_view key) {
  return fmt::format("unknown key {}{}", key, did_you_mean(key));
}

std::string unknown_table(std::string_view name, bool is_list) {
  const auto known = tables();
  const std::string written = in_brackets(name, is_list);
  auto candidates = known;
  if (is_list) std::ranges::reverse(candidates);  // the lists first
  if (const auto best = nearest(name, candidates))
    return fmt::format("unknown table {}; did you mean {}?", written,
                       in_brackets(*best, find_list(*best) != nullptr));
  return fmt::format("unknown table {}; known are {}", written, fmt::join(known, ", "));
}

std::string unknown_item_key(const List& list, std::string_view name) {
  std::vector<std::string_view> known;
  for (const Option& option : list.options) known.push_back(option.name());
  const std::string unknown = fmt::format("unknown key {}.{}", list.name, name);
  if (const auto best = nearest(name, known))
    return fmt::format("{}; did you mean {}.{}?", unknown, list.name, *best);
  return fmt::format("{}; known are {}", unknown, fmt::join(known, ", "));
}

}  // namespace tims::config
