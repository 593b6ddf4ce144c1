#include "base/toml.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

#include <toml++/toml.h>

#include "base/measure.h"
#include "base/text.h"

namespace tims::base {
namespace {

// Deeper nesting than any valid file has: the rest is treated as one foreign value.
constexpr int kDepthMax = 16;

Place place(const TextFile& file, const toml::source_position& at) {
  return {.file = file.name, .line = at.line, .column = at.column};
}

std::pair<std::uint32_t, std::uint32_t> order(const Place& at) { return {at.line, at.column}; }

TomlValue value_of(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* flag = node.as_boolean()) return flag->get();
  if (const auto* number = node.as_integer()) return number->get();
  if (const auto* fraction = node.as_floating_point()) return fraction->get();
  if (node.is_table()) return Foreign{"a table"};
  if (node.is_array_of_tables()) return Foreign{"an array of tables"};
  const toml::array* array = node.as_array();
  if (array == nullptr) return Foreign{"a date or time"};
  if (!array->is_homogeneous<std::string>()) return Foreign{"an array"};
  std::vector<std::string> texts;
  for (const toml::node& item : *array) texts.push_back(item.as_string()->get());
  return texts;
}

// The message of the TOML library, with the most frequent cause.
std::string explained(std::string_view description) {
  std::string text(description);
  const bool bare =
      text.find("value type") != std::string::npos || text.find("integer") != std::string::npos;
  if (bare && text.find("redefine") == std::string::npos)
    text += "; texts, sizes and durations stand in quotes";
  return text;
}

void append_children(const TextFile& file, const toml::node& node, int depth, TomlNode& out);

TomlNode tree_node(const TextFile& file, const toml::node& node, int depth) {
  const Place at = place(file, node.source().begin);
  TomlNode out{.at_key = at, .at_value = at, .value = value_of(node)};
  if (depth < kDepthMax) append_children(file, node, depth + 1, out);
  return out;
}

void append_children(const TextFile& file, const toml::node& node, int depth, TomlNode& out) {
  if (const toml::table* table = node.as_table()) {
    out.form = TomlNode::Form::kTable;
    for (const auto& [name, value] : *table) {
      out.children.push_back(tree_node(file, value, depth));
      out.children.back().key = std::string(name.str());
      out.children.back().at_key = place(file, name.source().begin);
    }
  } else if (const toml::array* array = node.as_array()) {
    out.form = TomlNode::Form::kArray;
    for (const toml::node& item : *array) out.children.push_back(tree_node(file, item, depth));
  }
  std::ranges::stable_sort(out.children, {},
                           [](const TomlNode& child) { return order(child.at_key); });
}

std::string label(const TomlNode& node) { return node.key.empty() ? "an item" : node.key; }

std::string real_text(double number) {
  std::array<char, 32> text{};  // the longest double has 24 characters
  return {text.data(), std::to_chars(text.begin(), text.end(), number).ptr};
}

std::string as_written(const TomlNode& node) {
  if (node.form == TomlNode::Form::kTable) return "a table";
  if (node.form == TomlNode::Form::kArray) return "an array";
  if (const auto* text = std::get_if<std::string>(&node.value)) return "\"" + *text + "\"";
  if (const auto* flag = std::get_if<bool>(&node.value)) return *flag ? "true" : "false";
  if (const auto* number = std::get_if<std::int64_t>(&node.value)) return std::to_string(*number);
  if (const auto* number = std::get_if<double>(&node.value)) return real_text(*number);
  return std::string(std::get<Foreign>(node.value).what);
}

// "NAME must be THIS, not THAT"
std::string must_be(const TomlNode& node, std::string_view wanted) {
  return label(node).append(" must be ").append(wanted).append(", not ").append(as_written(node));
}

const std::string* text_of(const TomlNode& node) {
  return node.form == TomlNode::Form::kValue ? std::get_if<std::string>(&node.value) : nullptr;
}

}  // namespace

std::string Problem::to_string() const {
  return at.file + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": " + text;
}

bool TomlNode::is_array_of_tables() const {
  return form == Form::kArray && !children.empty() &&
         std::ranges::all_of(children,
                             [](const TomlNode& child) { return child.form == Form::kTable; });
}

TomlTree parse_toml(const TextFile& file) {
  TomlTree result{.root = {.form = TomlNode::Form::kTable}, .problems = {}};
  try {
    const toml::table root = toml::parse(std::string_view{file.text});
    append_children(file, root, 0, result.root);
  } catch (const toml::parse_error& error) {
    result.problems.push_back({place(file, error.source().begin), explained(error.description())});
  }
  return result;
}

bool TomlReader::is(const TomlNode& node, TomlNode::Form form, std::string_view wanted) {
  if (node.form == form) return true;
  refuse(node, must_be(node, wanted));
  return false;
}

void TomlReader::table(const TomlNode& node, std::string_view what, std::span<const Key> keys) {
  if (!is(node, TomlNode::Form::kTable, "a table of keys")) return;
  std::vector<std::string> known;
  for (const Key& key : keys) known.emplace_back(key.name);
  for (const TomlNode& child : node.children) {
    const auto key = std::ranges::find(keys, child.key, &Key::name);
    if (key != keys.end())
      key->read(child);
    else
      unknown(child.at_key, "key of " + std::string(what), child.key, known);
  }
}

void TomlReader::tables(const TomlNode& node, const Read& each) {
  if (!is(node, TomlNode::Form::kArray, "[[" + node.key + "]] above the keys of each")) return;
  for (const TomlNode& child : node.children)
    if (is(child, TomlNode::Form::kTable, "a table of keys")) each(child);
}

void TomlReader::named_tables(const TomlNode& node, const Read& each) {
  if (!is(node, TomlNode::Form::kTable, "[" + node.key + ".NAME] above the keys of each")) return;
  for (const TomlNode& child : node.children)
    if (is(child, TomlNode::Form::kTable, "a table of keys")) each(child);
}

void TomlReader::texts(const TomlNode& node,
                       const std::function<void(const TomlNode&, const std::string&)>& each) {
  if (!is(node, TomlNode::Form::kArray, R"(a list such as ["a", "b"])")) return;
  for (const TomlNode& child : node.children) {
    if (const std::string* text = text_of(child))
      each(child, *text);
    else
      refuse(child, node.key + " must contain texts in quotes, not " + as_written(child));
  }
}

bool TomlReader::text(const TomlNode& node, std::string& out) {
  const std::string* text = text_of(node);
  if (text != nullptr)
    out = *text;
  else
    refuse(node, must_be(node, "a text in quotes"));
  return text != nullptr;
}

void TomlReader::plain(const TomlNode& node, std::string& out) {
  if (node.form != TomlNode::Form::kValue || std::holds_alternative<Foreign>(node.value))
    return refuse(node, must_be(node, "a number, a text, true or false"));
  if (const std::string* text = text_of(node))
    out = *text;
  else if (const bool* flag = std::get_if<bool>(&node.value))
    out = *flag ? "1" : "0";
  else
    out = as_written(node);
}

void TomlReader::number(const TomlNode& node, std::int64_t min, std::int64_t max,
                        std::int64_t& out) {
  const auto* number = std::get_if<std::int64_t>(&node.value);
  if (node.form == TomlNode::Form::kValue && number != nullptr && *number >= min && *number <= max)
    out = *number;
  else
    refuse(node,
           must_be(node, "a number from " + std::to_string(min) + " to " + std::to_string(max)));
}

void TomlReader::real(const TomlNode& node, double min, double max, double& out) {
  const auto* whole = std::get_if<std::int64_t>(&node.value);
  const auto* real = std::get_if<double>(&node.value);
  const bool is_number =
      node.form == TomlNode::Form::kValue && (whole != nullptr || real != nullptr);
  const double value = whole != nullptr ? static_cast<double>(*whole) : real != nullptr ? *real : 0;
  if (is_number && value >= min && value <= max)
    out = value;
  else
    refuse(node, must_be(node, "a number from " + real_text(min) + " to " + real_text(max)));
}

void TomlReader::duration(const TomlNode& node, bool zero, Duration& out) {
  const std::string* text = text_of(node);
  const auto value = text != nullptr ? parse_duration(*text) : std::nullopt;
  if (value && (*value > Duration{} || (zero && *value == Duration{})))
    out = *value;
  else
    refuse(node, must_be(node, "a duration such as \"5s\""));
}

void TomlReader::unknown(const Place& at, std::string_view what, std::string_view name,
                         std::span<const std::string> known) {
  std::string text = "unknown " + std::string(what) + " \"" + std::string(name) + "\"; ";
  if (const auto near = nearest(name, known)) {
    text.append("did you mean ").append(*near).append("?");
  } else {
    text += "there are ";
    for (const std::string& each : known)
      text.append(&each == known.data() ? "" : ", ").append(each);
  }
  problems_.push_back({at, std::move(text)});
}

std::vector<Problem> TomlReader::problems() const {
  auto sorted = problems_;
  std::ranges::stable_sort(sorted, {}, [](const Problem& problem) { return order(problem.at); });
  return sorted;
}

}  // namespace tims::base
