#include "tests/bench/options.h"

#include <algorithm>
#include <charconv>

namespace tims::bench {
namespace {

Result<double> number(const std::string& option, const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc{} && end == text.data() + text.size() && value > 0) return value;
  return Error(Errc::kInvalidArgument, option + " needs a number above 0, not \"" + text + "\"");
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

bool Options::selects(const std::string& scenario) const {
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
        return Error(Errc::kInvalidArgument, argument + " needs a value");
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
         "Compares libtims and tims-router with limits of this machine measured in the same run.\n"
         "Without SCENARIO all scenarios run. Everything runs on this host and exits by itself.\n"
         "Scenarios between hosts use network namespaces and need root.\n"
         "\n"
         "  --list       list the scenarios, one per line\n"
         "  --csv FILE   also write peer,scenario,payload_bytes,metric,value to FILE\n"
         "  --quick      run one repetition, fewer sizes, shorter: about a minute and a half\n"
         "  --reps N     number of interleaved repetitions; the median is shown (3)\n"
         "  --seconds S  length of each measurement in seconds (0.3 for round trips, 0.8 for "
         "streams, "
         "6 for links)\n"
         "  --help       show this help\n";
}

}  // namespace tims::bench
