#include "tests/bench/options.h"

#include <algorithm>
#include <charconv>

namespace tims::bench {
namespace {

Result<double> number(const std::string& option, const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc{} && end == text.data() + text.size() && value > 0) return value;
  return Error(Errc::kInvalidArgument, option + " wants a number above 0, not \"" + text + "\"");
}

Result<void> take_valued(Options& options, const std::string& option, const std::string& value) {
  if (option == "--csv") {
    options.csv = value;
    return {};
  }
  const auto parsed = number(option, value);
  if (!parsed) return parsed.error();
  if (option == "--reps") {
    options.reps = std::max(1, static_cast<int>(*parsed));
  } else {
    options.seconds = Duration(static_cast<Duration::rep>(*parsed * 1e9));
  }
  return {};
}

bool take_flag(Options& options, const std::string& option) {
  if (option == "--quick") {
    options.quick = true;
  } else if (option == "--list") {
    options.list = true;
  } else if (option == "--help" || option == "-h") {
    options.help = true;
  } else {
    return false;
  }
  return true;
}

}  // namespace

bool Options::wants(const std::string& scenario) const {
  if (scenarios.empty()) return true;
  const std::string base = scenario.substr(0, scenario.find('@'));
  return std::any_of(scenarios.begin(), scenarios.end(),
                     [&](const std::string& s) { return s == scenario || s == base; });
}

Result<Options> parse_options(std::span<const std::string> arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& argument = arguments[i];
    if (!argument.starts_with("-")) {
      options.scenarios.push_back(argument);
    } else if (argument == "--csv" || argument == "--reps" || argument == "--seconds") {
      if (++i == arguments.size())
        return Error(Errc::kInvalidArgument, argument + " wants a value");
      if (auto taken = take_valued(options, argument, arguments[i]); !taken) return taken.error();
    } else if (!take_flag(options, argument)) {
      return Error(Errc::kInvalidArgument, "unknown option " + argument + "; see --help");
    }
  }
  return options;
}

std::string help_text() {
  return "tims-bench [OPTION...] [SCENARIO...]\n"
         "\n"
         "Measures libtims and tims-router beside limits of this machine measured in the same "
         "run.\n"
         "Without a scenario: all of them. Everything runs on this host and ends by itself. What "
         "lies\n"
         "between hosts is measured between network namespaces, as root.\n"
         "\n"
         "  --list       scenarios, a line each\n"
         "  --csv FILE   also writes peer,scenario,payload_bytes,metric,value\n"
         "  --quick      one repetition, fewer sizes, shorter: about a minute and a half\n"
         "  --reps N     interleaved repetitions, of which the median counts (3)\n"
         "  --seconds S  length of each measurement (0.3 for round trips, 0.8 for streams, 6 for "
         "links)\n"
         "  --help       this\n";
}

}  // namespace tims::bench
