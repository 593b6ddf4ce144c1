// fleet_chaos: see README.md.
#include <cstdio>
#include <optional>
#include <random>
#include <string>
#include <string_view>

#include "base/measure.h"
#include "base/text.h"
#include "tests/chaos/client.h"
#include "tests/chaos/run.h"
#include "tools/cli/argument_parser.h"
#include "tools/cli/failure.h"

namespace tims::chaos {
namespace {

constexpr int kSkipped = 77;
constexpr std::size_t kRobotsMax = (kClientsMax / kClientsPerHost - 1) / 2;

int be_client(std::string_view number, const std::string& path) {
  const auto own = base::parse_number<std::size_t>(number);
  const auto board = SharedBoard::at(path);
  if (!own || !board) return 2;
  return run_client(*board, *own);
}

int run(const Settings& settings) {
  const timsctl::Signals signals;  // before any thread
  try {
    return Run(settings, signals).go() ? 0 : 1;
  } catch (const timsctl::Interrupted&) {
    std::puts("interrupted");
    return 130;
  } catch (const timsctl::Failure& failure) {
    std::printf("%s\n%s\n", failure.message.c_str(), failure.hint.c_str());
    return failure.exit == timsctl::Exit::kDenied ? kSkipped : 1;
  }
}

int run(int argc, char** argv) {
  Settings settings;
  std::optional<std::uint64_t> seed;
  std::string length = "10min";
  timsctl::ArgumentParser parser("fleet_chaos",
                                 "Runs a fleet in network namespaces (needs root). Routers and "
                                 "clients are killed and started,\n"
                                 "lines are cut and degraded, at random and in rounds. After each "
                                 "round all faults are removed\n"
                                 "and the invariants are checked. Exit status 1: an invariant is "
                                 "violated; 77: a fleet cannot\n"
                                 "be created here.");
  parser.option("--seed", seed, "repeat the run with this seed");
  parser.option("--for", length, "length of the run: 15s, 10min");
  parser.option("--robots", settings.robots, "number of robots", {1, kRobotsMax});
  return parser.run(argc, argv, [&] {
    const auto parsed = base::parse_duration(length);
    if (!parsed) throw timsctl::usage_error("--for: \"" + length + "\" is not a duration");
    settings.length = *parsed;
    settings.seed = seed ? *seed : std::random_device()();
    return static_cast<timsctl::Exit>(run(settings));
  });
}

}  // namespace
}  // namespace tims::chaos

int main(int argc, char** argv) {
  if (argc == 4 && std::string_view(argv[1]) == "client")
    return tims::chaos::be_client(argv[2], argv[3]);
  return tims::chaos::run(argc, argv);
}
