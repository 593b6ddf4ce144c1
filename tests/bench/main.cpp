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

int play_role(const std::vector<std::string>& arguments) {
  const auto plan = parse_plan(arguments);
  if (!plan) return std::fprintf(stderr, "tims-bench: %s\n", plan.error().message().c_str()), 2;
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

int run(const Options& options) {
  if (options.list) return list();
  for (const std::string& wanted : options.scenarios)
    if (!is_known(wanted))
      throw timsctl::usage_error("unknown scenario " + wanted, "`tims-bench --list`");
  return run_bench(options, std::filesystem::read_symlink("/proc/self/exe"));
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (!arguments.empty() && arguments[0] == "--role") return play_role(arguments);
  Options options;
  timsctl::ArgumentParser parser(
      "tims-bench",
      "Compares libtims and tims-router with limits of this machine measured in the same run.\n"
      "Everything runs on this host and exits by itself. Scenarios between hosts use network\n"
      "namespaces and need root.");
  add_options(parser, options);
  return parser.run(argc, argv, [&] { return static_cast<timsctl::Exit>(run(options)); });
}
