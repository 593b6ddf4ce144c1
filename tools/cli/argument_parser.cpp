#include "tools/cli/argument_parser.h"

#include <cmath>
#include <cstdio>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

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

void ArgumentParser::command(std::vector<std::string>& values) {
  app_->prefix_command();
  command_ = &values;
}

void ArgumentParser::flag(const std::string& names, bool& value, const std::string& help) {
  app_->add_flag(names, value, help);
}

void ArgumentParser::flag(const std::string& names, std::function<void()> set) {
  app_->add_flag_callback(names, std::move(set));
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

void ArgumentParser::option(const std::string& names, std::string_view type,
                            const std::function<void(const std::string&)>& set) {
  app_->add_option_function(names, set)->type_name(std::string(type));
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
  if (command_ != nullptr) *command_ = app_->remaining();
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

}  // namespace timsctl
