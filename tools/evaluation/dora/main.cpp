// rack-dora: the robot Dora on her three hosts, and whether she does what she shall.
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <unistd.h>

#include "base/measure.h"
#include "os/environment.h"
#include "tools/cli/failure.h"
#include "tools/evaluation/dora/scenario.h"

namespace rack::dora {
namespace {

using timsctl::Exit;

constexpr const char* kAbout =
    "The robot Dora of RACK's paper: her ten components on three hosts, in network namespaces of\n"
    "this machine (root), at the paper's periods and priorities. She drives her round while she\n"
    "is measured and things are done to her; at the end a table says what was wanted, what was\n"
    "measured, and whether it held. tools/evaluation/dora/README.md has the list.";
constexpr const char* kExits =
    "Exit status: 0 all of it held, 1 something did not (the table says what to look at), 2 wrong\n"
    "command line, 3 only what this machine's timers are too late for, 5 no fleet can be made "
    "here.";

// Robot files call programs by their names.
void find_own_programs() {
  const std::string folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const std::string path = tims::os::environment("PATH");
  const std::string all = folder + ":" + (path.empty() ? "/usr/bin:/bin" : path);
  ::setenv("PATH", all.c_str(), 1);  // NOLINT(concurrency-mt-unsafe): before any thread
}

Exit run(Settings settings, const std::string& length, bool json) {
  const auto parsed = tims::base::parse_duration(length);
  if (!parsed || *parsed < std::chrono::seconds(1))
    throw timsctl::usage_error(fmt::format("--for: \"{}\" is no duration", length),
                               "write 60s or 10min");
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
  CLI::App app(kAbout, "rack-dora");
  app.add_option("--for", length, "how long in all, about (60s, 10min)")->capture_default_str();
  app.add_option("--fleet-file", settings.fleet_file, "her fleet")->capture_default_str();
  app.add_option(
      "--logs", settings.logs,
      "folder for the logs of all programs, and drive.csv: where she was and believed to be");
  app.add_flag("--json", json, "the table as JSON, and nothing else on stdout");
  app.set_version_flag("--version", TIMS_VERSION);
  app.footer(kExits);
  return timsctl::run_program(argc, argv, app, [&] { return run(settings, length, json); });
}
