// fleet_chaos [--seed N] [--for DURATION] [--robots N]: see README.md.
#include <charconv>
#include <cstdio>
#include <random>
#include <string>
#include <string_view>

#include "base/measure.h"
#include "tests/chaos/client.h"
#include "tests/chaos/run.h"
#include "tools/cli/failure.h"

namespace tims::chaos {
namespace {

constexpr const char* kUsage =
    "usage: fleet_chaos [--seed N] [--for DURATION] [--robots N]\n\n"
    "Runs a fleet in network namespaces (needs root). Routers and clients are killed and started,\n"
    "lines are cut and degraded, at random and in rounds, for DURATION (15s, 10min). After each\n"
    "round all faults are removed and the invariants are checked. Exit status 1: an invariant is\n"
    "violated; 77: a fleet cannot be created here. --seed repeats a run.\n";
constexpr int kSkipped = 77;
constexpr std::size_t kRobotsMax = (kClientsMax / kClientsPerHost - 1) / 2;

template <typename Number>
bool parse(std::string_view text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

// False: invalid arguments.
bool parse(int argc, char** argv, Settings& settings) {
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string_view name = argv[i];
    const std::string_view value = argv[i + 1];
    if (name == "--for") {
      const auto length = base::parse_duration(value);
      if (!length) return false;
      settings.length = *length;
    } else if (!(name == "--seed" && parse(value, settings.seed)) &&
               !(name == "--robots" && parse(value, settings.robots))) {
      return false;
    }
  }
  return argc % 2 == 1 && settings.robots > 0 && settings.robots <= kRobotsMax;
}

int be_client(std::string_view number, const std::string& path) {
  std::size_t own = 0;
  const auto board = SharedBoard::at(path);
  if (!parse(number, own) || !board) return 2;
  return run_client(*board, own);
}

int run(int argc, char** argv) {
  Settings settings{.seed = std::random_device()(), .length = std::chrono::minutes(10)};
  if (!parse(argc, argv, settings)) return std::fputs(kUsage, stderr), 2;
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

}  // namespace
}  // namespace tims::chaos

int main(int argc, char** argv) {
  if (argc == 4 && std::string_view(argv[1]) == "client")
    return tims::chaos::be_client(argv[2], argv[3]);
  return tims::chaos::run(argc, argv);
}
