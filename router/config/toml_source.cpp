#include "router/config/toml_source.h"

#include <algorithm>

#include <toml++/toml.h>

namespace tims::config {
namespace {

Origin origin(const File& file, const toml::source_position& at) {
  return {.kind = Origin::Kind::kFile, .file = file.name, .line = at.line, .column = at.column};
}

std::optional<std::vector<std::string>> texts(const toml::node& node) {
  const toml::array* array = node.as_array();
  if (array == nullptr || !array->is_homogeneous<std::string>()) return std::nullopt;
  std::vector<std::string> all;
  for (const toml::node& item : *array) all.push_back(item.as_string()->get());
  return all;
}

Raw raw_value(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* flag = node.as_boolean()) return flag->get();
  if (const auto* number = node.as_integer()) return number->get();
  if (const auto* fraction = node.as_floating_point()) return fraction->get();
  if (node.is_table()) return Foreign{"a table"};
  if (node.is_array_of_tables()) return Foreign{"an array of tables"};
  if (auto list = texts(node)) return std::move(*list);
  if (node.is_array()) return Foreign{"an array"};
  return Foreign{"a date or time"};
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

std::pair<std::uint32_t, std::uint32_t> place(const Origin& at) { return {at.line, at.column}; }

// Nested deeper than any file that means something: the rest is one foreign value.
constexpr int kDepthMax = 16;

void append_children(const File& file, const toml::node& node, int depth, TomlNode& out);

TomlNode tree_node(const File& file, const toml::node& node, int depth) {
  TomlNode out{.at_key = origin(file, node.source().begin),
               .at_value = origin(file, node.source().begin),
               .value = raw_value(node)};
  if (depth < kDepthMax) append_children(file, node, depth + 1, out);
  return out;
}

void append_children(const File& file, const toml::node& node, int depth, TomlNode& out) {
  if (const toml::table* table = node.as_table()) {
    out.form = TomlNode::Form::kTable;
    for (const auto& [name, value] : *table) {
      out.children.push_back(tree_node(file, value, depth));
      out.children.back().key = std::string(name.str());
      out.children.back().at_key = origin(file, name.source().begin);
    }
  } else if (const toml::array* array = node.as_array()) {
    out.form = TomlNode::Form::kArray;
    for (const toml::node& item : *array) out.children.push_back(tree_node(file, item, depth));
  }
  std::ranges::stable_sort(out.children, {},
                           [](const TomlNode& child) { return place(child.at_key); });
}

}  // namespace

TomlTree parse_toml_tree(const File& file) {
  TomlTree result{.root = {.form = TomlNode::Form::kTable}, .problems = {}};
  try {
    const toml::table root = toml::parse(std::string_view{file.text});
    append_children(file, root, 0, result.root);
  } catch (const toml::parse_error& error) {
    result.problems.push_back({origin(file, error.source().begin), explained(error.description())});
  }
  return result;
}

}  // namespace tims::config
