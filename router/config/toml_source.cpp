#include "router/config/toml_source.h"

#include <algorithm>

#include <toml++/toml.h>

namespace tims::config {
namespace {

Origin origin(const File& file, const toml::source_position& at) {
  return {.kind = Origin::Kind::kFile, .file = file.name, .line = at.line, .column = at.column};
}

Raw raw_value(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* flag = node.as_boolean()) return flag->get();
  if (const auto* number = node.as_integer()) return number->get();
  if (node.is_floating_point()) return Foreign{"a number with a fraction"};
  if (node.is_table()) return Foreign{"a table"};
  if (node.is_array_of_tables()) return Foreign{"an array of tables"};
  if (node.is_array()) return Foreign{"an array"};
  return Foreign{"a date or time"};
}

void append(const File& file, const std::string& prefix, const toml::key& key,
            const toml::node& node, std::vector<Assignment>& out) {
  out.push_back({.key = prefix + std::string(key.str()),
                 .at_key = origin(file, key.source().begin),
                 .at_value = origin(file, node.source().begin),
                 .value = raw_value(node),
                 .table = prefix.empty() && node.is_table()});
  if (!out.back().table) return;
  // Options are one table deep: what lies deeper stays one foreign value.
  const std::string inner = out.back().key + ".";
  for (const auto& [name, value] : *node.as_table()) append(file, inner, name, value, out);
}

// The library's words, and what is behind them most often.
std::string explained(std::string_view description) {
  std::string text(description);
  const bool bare =
      text.find("value type") != std::string::npos || text.find("integer") != std::string::npos;
  if (bare && text.find("redefine") == std::string::npos)
    text += "; texts, sizes and durations stand in quotes";
  return text;
}

}  // namespace

TomlText parse_toml(const File& file) {
  TomlText result;
  try {
    const toml::table root = toml::parse(std::string_view{file.text});
    for (const auto& [name, value] : root) append(file, "", name, value, result.assignments);
  } catch (const toml::parse_error& error) {
    result.assignments.clear();
    result.problems.push_back({origin(file, error.source().begin), explained(error.description())});
  }
  std::ranges::stable_sort(result.assignments, {}, [](const Assignment& a) {
    return std::pair(a.at_key.line, a.at_key.column);
  });
  return result;
}

}  // namespace tims::config
