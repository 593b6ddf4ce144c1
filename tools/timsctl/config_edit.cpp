#include "tools/timsctl/config_edit.h"

#include <fmt/format.h>

#include "base/toml.h"
#include "tools/cli/arguments.h"
#include "tools/cli/failure.h"
#include "tools/cli/output.h"

namespace timsctl {
namespace {

// A value in TOML; what is none is a text: the shell takes quotes away.
json::value value_of(const std::string& text) {
  const base::TomlTree tree = base::parse_toml({"", "value = " + text});
  if (!tree.problems.empty() || tree.root.children.size() != 1) return json::value(text);
  json::value made = json_of(tree.root.children.front());
  return made.is_null() ? json::value(text) : made;
}

}  // namespace

ConfigEdit parse_config_edit(std::string_view argument) {
  const auto wrong = [whole = argument] {
    return usage_error(
        fmt::format("\"{}\" is no edit", whole),
        "robots/scout.toml=FILE, or robots/scout.toml:component[2].parameters.maxRange=10000");
  };
  ConfigEdit edit;
  if (const std::size_t at = argument.find('@'); at < argument.find_first_of(":=")) {
    edit.router = argument.substr(0, at);
    argument.remove_prefix(at + 1);
  }
  const std::size_t end = argument.find_first_of(":=");
  if (end == std::string_view::npos || end == 0) throw wrong();
  edit.file = argument.substr(0, end);
  std::string_view rest = argument.substr(end + 1);
  if (argument[end] == ':') {
    // A quoted key may have an equals sign.
    bool in_quotes = false;
    std::size_t equals = 0;
    for (; equals < rest.size() && (in_quotes || rest[equals] != '='); ++equals)
      in_quotes = in_quotes != (rest[equals] == '"');
    if (equals == rest.size() || equals == 0) throw wrong();
    edit.path = rest.substr(0, equals);
    rest.remove_prefix(equals + 1);
  } else if (rest.empty()) {
    throw wrong();
  }
  edit.source = rest;
  return edit;
}

std::string diff_in_colour(std::string_view diff, bool colour) {
  std::string text;
  for (const std::string_view line : parts_of(diff, '\n')) {
    if (line.empty()) continue;
    const Tone tone = line.starts_with('+')   ? Tone::kGood
                      : line.starts_with('-') ? Tone::kBad
                      : line.starts_with('@') ? Tone::kDim
                                              : Tone::kPlain;
    text += paint(line, tone, colour) + "\n";
  }
  return text;
}

json::object operation_of(const ConfigEdit& edit) {
  if (edit.source.empty()) return {{"op", "remove"}, {"path", edit.path}};
  return {{"op", "set"}, {"path", edit.path}, {"value", value_of(edit.source)}};
}

}  // namespace timsctl
