#include "tools/cli/argument_parser.h"

#include <cmath>
#include <cstdio>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "tools/cli/options.h"
#include "tools/cli/program.h"

namespace timsctl {
namespace {

template <typename T>
struct NumberOf {
  using Type = T;
  static constexpr bool kHasDefault = true;
};
template <typename T>
struct NumberOf<std::optional<T>> {
  using Type = T;
  static constexpr bool kHasDefault = false;
};

// CLI11 takes the next argument as the value of "--sort=". No argument contains this character.
constexpr char kEmptyValue = '\0';

bool has_empty_value(std::string_view token) {
  return token.starts_with("--") && token.ends_with('=');
}
std::string without_mark(std::string text) {
  if (text.ends_with(kEmptyValue)) text.pop_back();
  return text;
}

// `given` is called for each time that the option is given.
void add_row(CLI::App& app, const OptionRow& row,
             const std::function<void(const std::string&)>& given) {
  std::string names = fmt::format("--{}", row.name);
  if (row.letter != 0) names += fmt::format(",-{}", row.letter);
  CLI::Option& option = row.value.empty() ? *app.add_flag(names) : *app.add_option(names);
  option.trigger_on_parse()->each(given);
  if (row.value.empty() || row.takes_value()) return;
  const std::string_view usual = row.value.substr(1, row.value.size() - 2);  // of "[2]"
  option.expected(0, 1)->default_str(std::string(usual));
}

// All arguments, after one more at the beginning. CLI11 passes arguments to an option whose value
// is optional ("--watch robot1"), except if they are required; more are required than there can be.
CLI::Option& add_arguments(CLI::App& app, const CommandBegins& command_begins) {
  constexpr int kMany = 1 << 20;
  app.validate_positionals();
  const auto look = [&app, &command_begins,
                     seen = std::vector<std::string>()](const std::string& argument) mutable {
    seen.push_back(argument);
    if (command_begins(std::span(seen).subspan(1))) app.positionals_at_end();
    return std::string();  // valid
  };
  return *app.add_option("ARGUMENT")->required()->expected(kMany)->take_all()->check(look);
}

}  // namespace

ArgumentParser::ArgumentParser(std::string call, const std::string& about, const std::string& more)
    : call_(std::move(call)), app_(std::make_unique<CLI::App>(about, call_)) {
  app_->set_version_flag("--version", std::string(own_version()));
  app_->footer(more);
}

ArgumentParser::~ArgumentParser() = default;

void ArgumentParser::argument(const char* name, std::string& value, const std::string& help) {
  app_->add_option(name, value, help);
}

void ArgumentParser::required_argument(const char* name, std::string& value,
                                       const std::string& help) {
  app_->add_option(name, value, help)->required();
}

void ArgumentParser::arguments(const char* name, std::vector<std::string>& values,
                               const std::string& help) {
  app_->add_option(name, values, help);
}

void ArgumentParser::flag(const std::string& names, bool& value, const std::string& help) {
  app_->add_flag(names, value, help);
}

template <typename T>
void ArgumentParser::option(const std::string& names, T& value, const std::string& help,
                            OptionRange range) {
  CLI::Option& option = *app_->add_option(names, value, help);
  using Number = typename NumberOf<T>::Type;
  if constexpr (NumberOf<T>::kHasDefault) option.capture_default_str();
  if constexpr (std::is_arithmetic_v<Number>) {
    if (std::isfinite(range.min))
      option.check(CLI::Range(static_cast<Number>(range.min), static_cast<Number>(range.max)));
  }
}

template void ArgumentParser::option(const std::string&, std::string&, const std::string&,
                                     OptionRange);
template void ArgumentParser::option(const std::string&, double&, const std::string&, OptionRange);
template void ArgumentParser::option(const std::string&, int&, const std::string&, OptionRange);
template void ArgumentParser::option(const std::string&, std::uint32_t&, const std::string&,
                                     OptionRange);
template void ArgumentParser::option(const std::string&, std::uint64_t&, const std::string&,
                                     OptionRange);
template void ArgumentParser::option(const std::string&, std::vector<std::uint32_t>&,
                                     const std::string&, OptionRange);
template void ArgumentParser::option(const std::string&, std::optional<double>&, const std::string&,
                                     OptionRange);
template void ArgumentParser::option(const std::string&, std::optional<std::uint64_t>&,
                                     const std::string&, OptionRange);

void ArgumentParser::option(const std::string& names, const char* type,
                            std::vector<std::string>& values, const std::string& help) {
  app_->add_option(names, values, help)
      ->type_name(type)
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
}

ArgumentParser::Asked ArgumentParser::parse(std::span<const std::string> arguments) {
  try {
    std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
    app_->parse(reversed);  // CLI11 expects the arguments in reverse order
  } catch (const CLI::CallForHelp&) {
    return Asked::kHelp;
  } catch (const CLI::CallForVersion&) {
    return Asked::kVersion;
  } catch (const CLI::ParseError& error) {
    throw refused(error.what());
  }
  return Asked::kRun;
}

// An option with a wrong name is the likeliest reason, whatever else CLI11 reports.
Failure ArgumentParser::refused(const std::string& reason) const {
  const std::string help = fmt::format("`{} --help`", call_);
  const auto extra = app_->remaining(true);
  if (extra.empty()) return usage_error(reason, help);
  const std::string name = extra.front().substr(0, extra.front().find('='));
  if (!name.starts_with('-'))
    return usage_error(fmt::format("unexpected argument \"{}\"", extra.front()), help);
  std::vector<std::string> known;
  for (const CLI::Option* option : app_->get_options())
    for (const std::string& each : option->get_lnames()) known.push_back("--" + each);
  return usage_error(
      fmt::format("{} has no option {}", call_, name),
      nearest_hint(name, std::vector<std::string_view>(known.begin(), known.end()), help));
}

std::string ArgumentParser::help() const { return app_->help(); }

int ArgumentParser::run(int argc, char** argv, const std::function<Exit()>& run) {
  try {
    const Asked asked = parse(std::vector<std::string>(argv + 1, argv + argc));
    if (asked == Asked::kRun) return static_cast<int>(run());
    fmt::print("{}", asked == Asked::kHelp ? help() : fmt::format("{}\n", own_version()));
    return static_cast<int>(Exit::kDone);
  } catch (const Failure& failure) {
    std::fputs(failure_text(failure).c_str(), stderr);
    return static_cast<int>(failure.exit);
  } catch (const Interrupted&) {
    return static_cast<int>(Exit::kInterrupted);
  }
}

Line split_line(std::span<const std::string> arguments, const CommandBegins& command_begins) {
  Line line;
  CLI::App app;
  app.set_help_flag();
  app.add_flag("--help,-h", line.help);
  app.add_flag("--version", line.version);
  for (const OptionRow& row : option_table())
    add_row(app, row, [&](const std::string& value) {
      if (row.value.empty() && value != "true")
        line.failure = usage_error(fmt::format("--{} does not take a value", row.name));
      line.options.push_back({&row, without_mark(value)});
    });
  const CLI::Option& found = add_arguments(app, command_begins);
  app.allow_extras();
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
  for (std::string& token : reversed)
    if (has_empty_value(token)) token.push_back(kEmptyValue);
  reversed.emplace_back("timsctl");
  try {
    app.parse(reversed);
  } catch (const CLI::ArgumentMismatch& error) {
    const std::string what = error.what();  // "--count: 1 required ..."
    const std::string name = what.substr(0, what.find(':'));
    const OptionRow* const row = find_option(std::string_view(name).substr(2));
    line.failure = usage_error(
        fmt::format("{} needs a value: {}", name, row != nullptr ? row->value : "TEXT"));
  } catch (const CLI::ParseError& error) {
    line.failure = usage_error(error.what());
  }
  for (const std::string& argument : std::span(found.results()).subspan(1))
    line.arguments.push_back(without_mark(argument));
  for (const std::string& option : app.remaining())
    if (option != "--" && line.unknown.empty()) line.unknown = without_mark(option);
  return line;
}

}  // namespace timsctl
