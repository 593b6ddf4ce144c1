#include "tools/timsctl/command_line.h"

#include <algorithm>

#include <fmt/format.h>

#include "tools/timsctl/failure.h"
#include "tools/timsctl/help.h"
#include "tools/timsctl/option_table.h"
#include "tools/timsctl/words.h"

namespace timsctl {

namespace {

bool is_in(std::string_view name, std::string_view list) {
  return fmt::format(" {} ", list).find(fmt::format(" {} ", name)) != std::string::npos;
}

// "--count=5", as split_words left it.
void set_option(const Verb& verb, std::string_view word, Options& options) {
  const std::string_view name = word.substr(2, word.find('=') - 2);
  const std::size_t equals = word.find('=');
  const std::string_view value =
      equals == std::string_view::npos ? std::string_view() : word.substr(equals + 1);
  if (!is_in(name, verb.options) && !is_in(name, kGeneralOptions))
    throw usage_error(fmt::format("timsctl {} has no option --{}", verb.name(), name),
                      fmt::format("timsctl {} --help", verb.name()));
  try {
    find_option(name)->set(options, value);
  } catch (const Failure& failure) {
    throw usage_error(fmt::format("--{}: {}", name, failure.message));
  }
}

void check_number_of_arguments(const Verb& verb, const std::vector<std::string>& arguments) {
  const std::string usage = fmt::format("timsctl {} {}", verb.name(), verb.arguments);
  if (arguments.size() < verb.arguments_min)
    throw usage_error(fmt::format("timsctl {}: {} is missing", verb.name(), verb.arguments), usage);
  if (arguments.size() > verb.arguments_max)
    throw usage_error(fmt::format("timsctl {}: \"{}\" is one word too many", verb.name(),
                                  arguments[verb.arguments_max]),
                      usage);
}

void check_form(const Verb& verb, Format format) {
  if (is_in(form_name(format), verb.forms)) return;
  std::string known(verb.forms);
  for (std::size_t at = 0; (at = known.find(' ', at)) != std::string::npos; at += 2)
    known.replace(at, 1, ", ");
  throw usage_error(fmt::format("timsctl {} has no -o {}", verb.name(), form_name(format)),
                    "it has " + known);
}

Text help_for(const Words& words) {
  if (words.words.empty() || words.words.front() == "help") return {overview()};
  const Resolved found = resolve(words.words);
  const bool only_a_noun = words.words.size() == 1 && !is_single(found.noun);
  if (found.verb == nullptr || only_a_noun) return {noun_help(found.noun)};
  return {verb_help(*found.verb)};
}

bool contains(const std::vector<std::string>& words, std::string_view word) {
  return std::ranges::find(words, word) != words.end();
}

}  // namespace

std::variant<Command, Text> parse_command_line(std::span<const std::string> arguments) {
  if (!arguments.empty() && arguments[0] == "__complete") {
    Options options;
    options.arguments.assign(arguments.begin() + 1, arguments.end());
    return Command{resolve(arguments.first(1)).verb, std::move(options)};
  }
  Words words = split_words(arguments);
  if (contains(words.options, "--version")) return Text{version_text()};
  const bool help_word = !words.words.empty() && words.words.front() == "help";
  if (help_word || contains(words.options, "--help")) return help_for(words);

  if (words.words.empty()) words.words.emplace_back("status");
  const Resolved found = resolve(words.words);
  if (found.verb == nullptr)
    throw usage_error(fmt::format("timsctl {}: which verb?", found.noun),
                      fmt::format("timsctl {} --help", found.noun));
  Command command{found.verb, {}};
  for (const std::string& option : words.options) set_option(*found.verb, option, command.options);
  command.options.arguments.assign(words.words.begin() + static_cast<std::ptrdiff_t>(found.words),
                                   words.words.end());
  check_number_of_arguments(*found.verb, command.options.arguments);
  check_form(*found.verb, command.options.format);
  return command;
}

}  // namespace timsctl
