// tims-bench: compares libtims and tims-router with limits of the machine. See README.md.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/bench/options.h"
#include "tests/bench/plan.h"
#include "tests/bench/roles.h"
#include "tests/bench/run.h"
#include "tests/bench/scenarios.h"

namespace {

using namespace tims::bench;

int usage_failure(const tims::Error& error) {
  std::fprintf(stderr, "tims-bench: %s\n", error.message().c_str());
  return 2;
}

int play_role(const std::vector<std::string>& arguments) {
  const auto plan = parse_plan(arguments);
  if (!plan) return usage_failure(plan.error());
  return run_role(*plan) ? 0 : 1;
}

int list() {
  for (const ScenarioText& scenario : scenario_texts())
    std::printf("%-26s %s\n", scenario.name, scenario.text);
  return 0;
}

bool is_known(const std::string& name) {
  const std::vector<ScenarioText> texts = scenario_texts();
  const std::string base = name.substr(0, name.find('@'));
  return std::any_of(texts.begin(), texts.end(), [&](const ScenarioText& scenario) {
    return name == scenario.name || base == scenario.name;
  });
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (!arguments.empty() && arguments[0] == "--role") return play_role(arguments);
  const auto options = parse_options(arguments);
  if (!options) return usage_failure(options.error());
  if (options->help) {
    std::fputs(help_text().c_str(), stdout);
    return 0;
  }
  if (options->list) return list();
  for (const std::string& wanted : options->scenarios) {
    if (!is_known(wanted))
      return usage_failure(
          {tims::Errc::kInvalidArgument, "unknown scenario " + wanted + "; see --list"});
  }
  return run_bench(*options, std::filesystem::read_symlink("/proc/self/exe"));
}
