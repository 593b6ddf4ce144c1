// rack-dora: runs the robot Dora on its three hosts and judges whether it meets its requirements.
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include <fmt/core.h>
#include <unistd.h>

#include "base/measure.h"
#include "os/environment.h"
#include "tools/cli/argument_parser.h"
#include "tools/evaluation/dora/scenario.h"

namespace rack::dora {
namespace {

using timsctl::Exit;

constexpr const char* kAbout =
    "Run and judge the robot Dora of RACK's paper: its ten components on three hosts, in network\n"
    "namespaces of this machine (needs root), with the periods and priorities of the paper. The\n"
    "robot drives its round while its timing is measured and faults are injected. The result is a\n"
    "table of requirements, measured values and verdicts; tools/evaluation/dora/README.md lists\n"
    "the requirements.";
constexpr const char* kExits =
    "Exit status: 0 all requirements held, 1 a requirement did not hold (the table states where "
    "to\n"
    "look), 2 wrong command line, 3 a requirement did not hold only because the timers of this\n"
    "machine are too late, 5 the fleet cannot be started on this machine.";

// Robot files name programs without a path, so the folder of this program is put into PATH.
void find_own_programs() {
  const std::string folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const std::string path = tims::os::environment("PATH");
  const std::string all = folder + ":" + (path.empty() ? "/usr/bin:/bin" : path);
  ::setenv("PATH", all.c_str(), 1);  // NOLINT(concurrency-mt-unsafe): before any thread
}

Exit run(Settings settings, const std::string& length, bool json) {
  const auto parsed = tims::base::parse_duration(length);
  if (!parsed || *parsed < std::chrono::seconds(1))
    throw timsctl::usage_error(fmt::format("--for: \"{}\" is not a duration", length),
                               "write a duration such as 60s or 10min, at least 1s");
  settings.length = *parsed;
  settings.quiet = json;
  find_own_programs();
  const timsctl::Signals signals;  // before any thread
  const Outcome outcome = Scenario(settings, signals).run();
  if (json)
    fmt::print("{}\n", to_json(outcome.rows, outcome.reference));
  else
    fmt::print("\n{}", table(outcome.rows, outcome.reference, ::isatty(STDOUT_FILENO) != 0));
  return static_cast<Exit>(exit_status(outcome.rows));
}

}  // namespace
}  // namespace rack::dora

int main(int argc, char** argv) {
  using namespace rack::dora;
  Settings settings{.fleet_file = "deploy/fleets/dora.toml"};
  std::string length = "60s";
  bool json = false;
  timsctl::ArgumentParser parser("rack-dora", kAbout, kExits);
  parser.option("--for", length, "approximate duration of the run, such as 60s or 10min");
  parser.option("--fleet-file", settings.fleet_file, "the fleet file");
  parser.option(
      "--logs", settings.logs,
      "store the logs of all programs and drive.csv (true and estimated poses) in this folder");
  parser.flag("--json", json, "print only the table, as JSON");
  return parser.run(argc, argv, [&] { return run(settings, length, json); });
}
