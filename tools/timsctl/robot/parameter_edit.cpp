#include "tools/timsctl/robot/parameter_edit.h"

#include <algorithm>

#include <fmt/format.h>

#include "router/config/toml_source.h"
#include "router/config/value.h"

namespace timsctl::robot {

namespace {

using tims::config::in_quotes;
using tims::config::TomlNode;

constexpr std::string_view kDigits = "0123456789";

// "-12", "0.5": what TOML takes for a number as it is.
bool is_number(std::string_view text) {
  if (text.starts_with('-')) text.remove_prefix(1);
  const std::size_t point = text.find('.');
  const std::string_view whole = text.substr(0, point);
  const auto digits = [](std::string_view part) {
    return !part.empty() && part.find_first_not_of(kDigits) == std::string_view::npos;
  };
  return digits(whole) && (whole == "0" || !whole.starts_with('0')) &&
         (point == std::string_view::npos || digits(text.substr(point + 1)));
}

const TomlNode* child_of(const TomlNode& node, std::string_view key) {
  const auto found = std::ranges::find(node.children, key, &TomlNode::key);
  return found == node.children.end() ? nullptr : &*found;
}

// One text that is changed once.
class Editor {
 public:
  explicit Editor(std::string_view text) : text_(text) {}

  [[nodiscard]] std::string with(const TomlNode& component, const std::string& name,
                                 const std::string& value) const {
    const TomlNode* parameters = child_of(component, "parameters");
    if (parameters != nullptr) {
      const TomlNode* old = child_of(*parameters, name);
      return old != nullptr ? replaced(*old, value) : added(*parameters, name, value);
    }
    const std::string all = fmt::format("parameters = {{ {} }}", assignment(name, value));
    const auto last = std::ranges::find(component.children.rbegin(), component.children.rend(),
                                        TomlNode::Form::kValue, &TomlNode::form);
    const std::size_t end = end_of_value(place(last->at_value));
    return is_at('{', component) ? inserted(end, ", " + all) : new_line(end, *last, all);
  }

 private:
  [[nodiscard]] std::string replaced(const TomlNode& old, const std::string& value) const {
    const std::size_t begin = place(old.at_value);
    const bool was_text = is_at('"', old) || is_at('\'', old);
    const std::string now = !was_text && is_number(value) ? value : in_quotes(value);
    return std::string(text_.substr(0, begin)) + now +
           std::string(text_.substr(end_of_value(begin)));
  }

  [[nodiscard]] std::string added(const TomlNode& parameters, const std::string& name,
                                  const std::string& value) const {
    const std::string made = assignment(name, value);
    const std::size_t begin = place(parameters.at_value);
    const bool is_inline = is_at('{', parameters);
    if (parameters.children.empty() && is_inline) {
      const std::size_t close = std::min(text_.find('}', begin), text_.size() - 1);
      return std::string(text_.substr(0, begin)) + "{ " + made + " }" +
             std::string(text_.substr(close + 1));
    }
    if (parameters.children.empty()) return new_line(begin, parameters, made);
    const TomlNode& last = parameters.children.back();
    const std::size_t end = end_of_value(place(last.at_value));
    if (is_inline) return inserted(end, ", " + made);
    return new_line(end, last, is_at('[', parameters) ? made : "parameters." + made);
  }

  static std::string assignment(const std::string& name, const std::string& value) {
    return fmt::format("{} = {}", name, is_number(value) ? value : in_quotes(value));
  }

  [[nodiscard]] std::string inserted(std::size_t at, std::string_view what) const {
    return std::string(text_.substr(0, at)).append(what).append(text_.substr(at));
  }

  // Behind the line of `at`, as far to the right as `like`.
  [[nodiscard]] std::string new_line(std::size_t at, const TomlNode& like,
                                     const std::string& what) const {
    const std::size_t line = line_of(like.at_key.line);
    const std::size_t first = std::min(text_.find_first_not_of(" \t", line), text_.size());
    const std::string indented = std::string(text_.substr(line, first - line)) + what;
    const std::size_t end = text_.find('\n', at);
    if (end == std::string_view::npos) return std::string(text_) + "\n" + indented + "\n";
    const bool carriage = end > 0 && text_[end - 1] == '\r';
    return inserted(end + 1, indented + (carriage ? "\r\n" : "\n"));
  }

  [[nodiscard]] bool is_at(char c, const TomlNode& node) const {
    const std::size_t at = place(node.at_value);
    return at < text_.size() && text_[at] == c;
  }

  [[nodiscard]] std::size_t line_of(std::uint32_t line) const {
    std::size_t at = 0;
    for (; line > 1 && at < text_.size(); --line)
      at = std::min(text_.find('\n', at), text_.size() - 1) + 1;
    return at;
  }
  // Columns count characters.
  [[nodiscard]] std::size_t place(const tims::config::Origin& origin) const {
    std::size_t at = line_of(origin.line);
    const auto goes_on = [&] {
      return at < text_.size() && (static_cast<unsigned char>(text_[at]) & 0xC0) == 0x80;
    };
    for (std::uint32_t column = 1; column < origin.column && at < text_.size(); ++column) do
        ++at;
      while (goes_on());
    return at;
  }

  [[nodiscard]] std::size_t end_of_value(std::size_t at) const {
    for (const std::string_view quote : {R"(""")", "'''", "\"", "'"}) {
      if (!text_.substr(at).starts_with(quote)) continue;
      for (at += quote.size(); at < text_.size(); ++at) {
        if (text_.substr(at).starts_with(quote)) return at + quote.size();
        if (text_[at] == '\\' && quote.front() == '"') ++at;
      }
      return text_.size();
    }
    return std::min(text_.find_first_of(" \t\r\n,}]#", at), text_.size());
  }

  std::string_view text_;
};

std::string* argument(Component& component, const std::string& name) {
  const std::string begin = "--" + name + "=";
  const auto found = std::ranges::find_if(
      component.command, [&](const std::string& word) { return word.starts_with(begin); });
  return found == component.command.end() ? nullptr : &*found;
}

tims::Error refused(std::string text) { return {tims::Errc::kInvalidArgument, std::move(text)}; }

}  // namespace

tims::Result<EditedFile> with_parameters(const tims::config::File& file,
                                         std::optional<std::int64_t> system, std::size_t component,
                                         const std::map<std::string, std::string>& parameters) {
  EditedFile edited{.text = file.text, .changes = {}};
  Robot robot = read_robot(file, "robot", system).robot;
  for (const auto& [name, value] : parameters) {
    Component& changed = robot.components.at(component);
    const std::string word = fmt::format("--{}={}", name, value);
    std::string* old = argument(changed, name);
    if (old != nullptr && *old == word) continue;
    edited.changes.push_back({.name = name, .before = std::nullopt, .after = value});
    if (old != nullptr) {
      edited.changes.back().before = old->substr(name.size() + 3);
      *old = word;
    } else {
      changed.command.push_back(word);
    }
    const auto tree = tims::config::parse_toml_tree({file.name, edited.text});
    const TomlNode& node = child_of(tree.root, "component")->children.at(component);
    edited.text = Editor(edited.text).with(node, name, value);
    const RobotFile now = read_robot({file.name, edited.text}, "robot", system);
    if (!now.problems.empty())
      return refused(fmt::format("{} = {} cannot stand in a robot file: {}", name, value,
                                 now.problems.front().text));
    if (now.robot.components != robot.components)
      return refused(
          fmt::format("{} = {} cannot be written where its component stands in {}; "
                      "please write it there by hand",
                      name, value, file.name));
  }
  return edited;
}

}  // namespace timsctl::robot
