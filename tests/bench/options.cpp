#include "tests/bench/options.h"

#include <algorithm>

namespace tims::bench {

bool Options::selects(const std::string& scenario) const {
  if (scenarios.empty()) return true;
  const std::string base = scenario.substr(0, scenario.find('@'));
  return std::any_of(scenarios.begin(), scenarios.end(),
                     [&](const std::string& s) { return s == scenario || s == base; });
}

void add_options(timsctl::ArgumentParser& parser, Options& options) {
  parser.arguments("SCENARIO", options.scenarios, "scenarios to run; without: all");
  parser.flag("--list", options.list, "list the scenarios, one per line");
  parser.option("--csv", options.csv,
                "also write peer,scenario,payload_bytes,metric,value to this file");
  parser.flag("--quick", options.quick,
              "run one repetition, fewer sizes, shorter: about a minute and a half");
  parser.option("--reps", options.reps,
                "number of interleaved repetitions; the median is shown (3)", {1, 1e6});
  parser.option(
      "--seconds", options.seconds,
      "length of each measurement [s] (0.3 for round trips, 0.8 for streams, 6 for links)",
      {1e-3, 1e6});
}

}  // namespace tims::bench
