// What people read of the option table: --help and the sample file.
#include <algorithm>

#include <fmt/core.h>

#include "router/config/options.h"

namespace tims::config {
namespace {

constexpr std::string_view kSampleTop =
    "# Configuration of tims-router: every key with its default, switched off by a '#'.\n"
    "# Sizes (B, KiB, MiB, GiB) and durations (ms, s, min, h) carry units. ${NAME} in a text is\n"
    "# the environment variable. An unknown key is an error. tims-router --help says the same.\n"
    "# [[link]] and [[route]] at the end have no defaults: what stands there are examples.\n";

std::string default_text(const Option& option) {
  if (!option.default_note.empty()) return std::string(option.default_note);
  Config config;
  for (const List& list : lists()) list.append(config);
  return to_toml(option.get(config));
}

std::string sample_value(const Option& option) {
  return option.sample.empty() ? default_text(option) : std::string(option.sample);
}

// `text` in lines of at most 98 columns, each behind `margin`, the first behind `first`.
std::string wrapped(std::string_view text, std::string_view margin, std::string_view first) {
  constexpr std::size_t kWidth = 98;
  std::string out;
  std::string line(first);
  bool empty = true;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    if (!empty && line.size() + 1 + word.size() > kWidth) {
      out += line + '\n';
      line = margin;
      empty = true;
    }
    line += fmt::format("{}{}", empty ? "" : " ", word);
    empty = false;
    text.remove_prefix(std::min(text.size(), word.size() + 1));
  }
  return out + line + '\n';
}

std::string wrapped(std::string_view text, std::string_view margin) {
  return wrapped(text, margin, margin);
}

std::string full_help(const Option& option) {
  const bool restart = option.reload == Reload::kRestart;
  return fmt::format("{}{}", option.help, restart ? " Changes need a restart." : "");
}

std::string limits_text(const Option& option) {
  const std::string range = range_text(option.kind, option.range);
  return fmt::format("{}{}{}", kind_name(option.kind), range.empty() ? "" : ", ", range);
}

std::string option_help(const Option& option) {
  return fmt::format("  {}  ({}; default {})\n{}", option.key, limits_text(option),
                     default_text(option), wrapped(full_help(option), "      "));
}

std::string sample_option(const Option& option) {
  std::string out = wrapped(fmt::format("{} ({})", full_help(option), limits_text(option)), "# ");
  if (!option.default_note.empty())
    out += wrapped(fmt::format("Default: {}", option.default_note), "# ");
  return out + fmt::format("#{} = {}\n", option.name(), sample_value(option));
}

// The keys of an item in words, then examples behind '#'.
std::string sample_list(const List& list) {
  std::string out = "\n" + wrapped(list.help, "# ");
  for (const Option& option : list.options)
    out += wrapped(
        fmt::format("{} ({}; default {})", option.help, limits_text(option), default_text(option)),
        "#            ", fmt::format("# {:<10} ", option.name()));
  std::string_view items = list.sample_items;
  while (!items.empty()) {
    const std::string_view line = items.substr(0, items.find('\n'));
    out += fmt::format("#{}\n", line);
    items.remove_prefix(line.size() + 1);
  }
  return out;
}

}  // namespace

std::string options_help() {
  std::string out;
  for (const Option& option : options()) out += option_help(option);
  for (const List& list : lists()) {
    out += fmt::format("\n{}", wrapped(fmt::format("[[{}]] {}", list.name, list.help), "  "));
    out += fmt::format("      --set {}\n", list.sample_setting);
    for (const Option& option : list.options) out += option_help(option);
  }
  return out;
}

std::string sample_file() {
  std::string out(kSampleTop);
  std::string_view table;
  for (const Option& option : options()) {
    if (option.table() != table) {
      table = option.table();
      out += fmt::format("\n[{}]\n", table);
    }
    out += sample_option(option);
  }
  for (const List& list : lists()) out += sample_list(list);
  return out;
}

}  // namespace tims::config
