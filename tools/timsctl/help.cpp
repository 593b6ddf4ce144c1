#include "tools/timsctl/help.h"

#include <algorithm>

#include <fmt/format.h>

#include "tools/timsctl/option_table.h"
#include "tools/timsctl/verbs.h"

#ifndef TIMS_VERSION
#error "the build says which version this is"
#endif

namespace timsctl {

namespace {

constexpr std::size_t kWidth = 98;

// Up to its first full stop.
std::string_view first_sentence(std::string_view text) { return text.substr(0, text.find(". ")); }

std::string call_of(const Verb& verb) {
  return fmt::format("{}{}{}", verb.name(), verb.arguments.empty() ? "" : " ", verb.arguments);
}

std::string verb_line(const Verb& verb) {
  return fmt::format("  {:<29} {}\n", call_of(verb), first_sentence(verb.help));
}

std::string option_line(const OptionRow& row) {
  const std::string letter = row.letter != 0 ? fmt::format("-{}, ", row.letter) : "    ";
  const bool optional = row.value.starts_with('[');
  const std::string value = row.value.empty() ? ""
                            : optional        ? fmt::format("[={}", row.value.substr(1))
                                              : fmt::format(" {}", row.value);
  return fmt::format("  {:<29} {}\n", fmt::format("{}--{}{}", letter, row.name, value), row.help);
}

std::string option_lines(std::string_view names) {
  const std::string padded = fmt::format(" {} ", names);
  std::string text;
  for (const OptionRow& row : option_table())
    if (padded.find(fmt::format(" {} ", row.name)) != std::string::npos) text += option_line(row);
  return text;
}

// Broken at blanks.
std::string wrapped(std::string_view text) {
  std::string out;
  while (text.size() > kWidth) {
    const std::size_t blank = text.rfind(' ', kWidth);
    out.append(text.substr(0, blank)).append("\n");
    text.remove_prefix(blank + 1);
  }
  return out.append(text).append("\n");
}

constexpr std::string_view kExitCodes =
    "Exit status: 0 done, 1 no or failed, 2 wrong command line, 3 no router, 4 no such thing,\n"
    "5 denied, 6 no answer in time or only a part, 7 other protocol version, 130 interrupted.\n";

}  // namespace

std::string_view own_version() { return TIMS_VERSION; }
std::string version_text() { return "timsctl " TIMS_VERSION "\n"; }

bool is_single(std::string_view noun) {
  return std::ranges::any_of(
      verbs(), [&](const Verb& verb) { return verb.noun == noun && verb.verb.empty(); });
}

std::string overview() {
  std::string text =
      "timsctl NOUN [VERB] [ARGUMENTS] [OPTIONS]: asks a router and its components.\n"
      "Unique beginnings are enough (`timsctl mb li`); without a word it is `timsctl status`.\n\n";
  for (const Verb& verb : verbs())
    if (!verb.example.empty()) text += verb_line(verb);
  text += "\nGeneral options:\n" + option_lines(kGeneralOptions);
  text += "  -h, --help                    of a noun or verb: its options and an example\n";
  text +=
      "\nADDR is Ladar(3/0), Ladar/3/0 (needs no quotes), Ladar/3/0:2 or 0x03140000. A GLOB has *\n"
      "in any place: 'Ladar(*/0)', Ladar.\n"
      "Environment: TIMS_HOST as -H, TIMS_ROUTER the router of programs here, NO_COLOR.\n";
  return text.append(kExitCodes);
}

std::string noun_help(std::string_view noun) {
  std::string text = fmt::format("timsctl {} VERB\n", noun);
  for (const Verb& verb : verbs())
    if (verb.noun == noun) text += verb_line(verb);
  return text + fmt::format("More: timsctl {} VERB --help\n", noun);
}

std::string verb_help(const Verb& verb) {
  std::string text = fmt::format("timsctl {}\n\n{}", call_of(verb), wrapped(verb.help));
  const std::string own = option_lines(verb.options);
  if (!own.empty()) text += "\nOptions:\n" + own;
  text += "\nGeneral options:\n" + option_lines(kGeneralOptions);
  return text + fmt::format("\nExample:\n  {}\n", verb.example);
}

}  // namespace timsctl
