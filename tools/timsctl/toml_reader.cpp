#include "tools/timsctl/toml_reader.h"

#include <algorithm>

#include <fmt/format.h>

#include "router/config/nearest.h"
#include "tools/timsctl/failure.h"
#include "tools/timsctl/values.h"

namespace timsctl {

namespace {

std::string label(const TomlNode& node) { return node.key.empty() ? "an item" : node.key; }

std::string as_written(const TomlNode& node) {
  if (node.form == TomlNode::Form::kTable) return "a table";
  if (node.form == TomlNode::Form::kArray) return "an array";
  if (const auto* text = std::get_if<std::string>(&node.value)) return fmt::format("\"{}\"", *text);
  if (const auto* flag = std::get_if<bool>(&node.value)) return *flag ? "true" : "false";
  if (const auto* number = std::get_if<std::int64_t>(&node.value)) return std::to_string(*number);
  if (const auto* number = std::get_if<double>(&node.value)) return fmt::format("{}", *number);
  return std::string(std::get<tims::config::Foreign>(node.value).what);
}

}  // namespace

bool TomlReader::is(const TomlNode& node, TomlNode::Form form, std::string_view wanted) {
  if (node.form == form) return true;
  refuse(node, fmt::format("{} wants {}, not {}", label(node), wanted, as_written(node)));
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
      unknown(child.at_key, fmt::format("key of {}", what), child.key, known);
  }
}

void TomlReader::tables(const TomlNode& node, const Read& each) {
  const std::string wanted = fmt::format("[[{}]] above the keys of each", node.key);
  if (!is(node, TomlNode::Form::kArray, wanted)) return;
  for (const TomlNode& child : node.children)
    if (is(child, TomlNode::Form::kTable, "a table of keys")) each(child);
}

void TomlReader::named_tables(const TomlNode& node, const Read& each) {
  const std::string wanted = fmt::format("[{}.NAME] above the keys of each", node.key);
  if (!is(node, TomlNode::Form::kTable, wanted)) return;
  for (const TomlNode& child : node.children)
    if (is(child, TomlNode::Form::kTable, "a table of keys")) each(child);
}

void TomlReader::texts(const TomlNode& node,
                       const std::function<void(const TomlNode&, const std::string&)>& each) {
  if (!is(node, TomlNode::Form::kArray, R"(a list such as ["a", "b"])")) return;
  for (const TomlNode& child : node.children) {
    if (const auto* text = std::get_if<std::string>(&child.value);
        text != nullptr && child.form == TomlNode::Form::kValue)
      each(child, *text);
    else
      refuse(child, fmt::format("{} wants texts in quotes, not {}", node.key, as_written(child)));
  }
}

bool TomlReader::text(const TomlNode& node, std::string& out) {
  const auto* text = std::get_if<std::string>(&node.value);
  const bool is_text = node.form == TomlNode::Form::kValue && text != nullptr;
  if (is_text)
    out = *text;
  else
    refuse(node, fmt::format("{} wants a text in quotes, not {}", label(node), as_written(node)));
  return is_text;
}

void TomlReader::plain(const TomlNode& node, std::string& out) {
  const auto* text = std::get_if<std::string>(&node.value);
  const auto* flag = std::get_if<bool>(&node.value);
  if (node.form != TomlNode::Form::kValue ||
      std::holds_alternative<tims::config::Foreign>(node.value))
    return refuse(node, fmt::format("{} wants a number, a text, true or false, not {}", label(node),
                                    as_written(node)));
  if (text != nullptr)
    out = *text;
  else
    out = flag == nullptr ? as_written(node) : (*flag ? "1" : "0");
}

void TomlReader::number(const TomlNode& node, std::int64_t min, std::int64_t max,
                        std::int64_t& out) {
  const auto* number = std::get_if<std::int64_t>(&node.value);
  if (node.form == TomlNode::Form::kValue && number != nullptr && *number >= min && *number <= max)
    out = *number;
  else
    refuse(node, fmt::format("{} wants a number from {} to {}, not {}", label(node), min, max,
                             as_written(node)));
}

void TomlReader::duration(const TomlNode& node, bool zero, tims::Duration& out) {
  const auto* text = std::get_if<std::string>(&node.value);
  const bool is_text = node.form == TomlNode::Form::kValue && text != nullptr;
  const auto value = is_text ? parse_duration(*text) : std::nullopt;
  if (value && (*value > tims::Duration{} || (zero && *value == tims::Duration{})))
    out = *value;
  else
    refuse(node, fmt::format("{} wants a duration such as \"5s\", not {}", label(node),
                             as_written(node)));
}

void TomlReader::unknown(const tims::config::Origin& at, std::string_view what,
                         std::string_view name, std::span<const std::string> known) {
  const std::vector<std::string_view> names(known.begin(), known.end());
  const auto near = tims::config::nearest(name, names);
  const std::string hint = near ? fmt::format("did you mean {}?", *near)
                                : fmt::format("there are {}", fmt::join(names, ", "));
  problems_.push_back({at, fmt::format("unknown {} \"{}\"; {}", what, name, hint)});
}

std::vector<tims::config::Problem> TomlReader::problems() const {
  auto sorted = problems_;
  std::ranges::stable_sort(sorted, {}, [](const tims::config::Problem& problem) {
    return std::pair(problem.at.line, problem.at.column);
  });
  return sorted;
}

void fail_if_any(std::span<const tims::config::Problem> problems, const std::string& code,
                 const std::string& hint) {
  std::string text;
  for (const tims::config::Problem& problem : problems)
    text.append(text.empty() ? "" : "\n").append(problem.to_string());
  if (!text.empty()) throw Failure(Exit::kNo, code, text, hint);
}

}  // namespace timsctl
