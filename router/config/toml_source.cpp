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

using Assignments = std::vector<Assignment>;

// Options are one table deep: what lies deeper stays one foreign value.
void append_inner(const File& file, const Assignment& outer, const toml::table& table,
                  Assignments& out) {
  for (const auto& [name, value] : table)
    out.push_back({.key = outer.key + "." + std::string(name.str()),
                   .at_key = origin(file, name.source().begin),
                   .at_value = origin(file, value.source().begin),
                   .value = raw_value(value),
                   .item = outer.item});
}

void append(const File& file, const toml::key& key, const toml::node& node, Assignments& out) {
  Assignment assignment{.key = std::string(key.str()),
                        .at_key = origin(file, key.source().begin),
                        .at_value = origin(file, node.source().begin),
                        .value = raw_value(node),
                        .table = node.is_table() || node.is_array_of_tables()};
  if (const toml::table* table = node.as_table()) {
    out.push_back(assignment);
    append_inner(file, assignment, *table, out);
  } else if (!assignment.table) {
    out.push_back(assignment);
  } else {
    for (const toml::node& item : *node.as_array()) {
      assignment.item = assignment.item ? *assignment.item + 1 : 0;
      assignment.at_key = assignment.at_value = origin(file, item.source().begin);
      out.push_back(assignment);
      append_inner(file, assignment, *item.as_table(), out);
    }
  }
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
    for (const auto& [name, value] : root) append(file, name, value, result.assignments);
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
