// sim_swarm: simulates random networks, as the test does.
#include <cstdio>
#include <string>

#include "tests/sim/restart_storm.h"
#include "tests/sim/swarm.h"
#include "tools/cli/argument_parser.h"

namespace {

using timsctl::Exit;

Exit run(std::uint64_t seed, std::uint64_t count, bool verbose) {
  std::uint64_t bad = 0;
  tims::sim::SwarmTotals sum;
  for (std::uint64_t n = seed; n < seed + count; ++n) {
    tims::sim::Swarm swarm(n, verbose);
    const auto failures = swarm.run();
    bad += failures.empty() ? 0 : 1;
    for (const std::string& failure : failures)
      std::printf("seed %llu: %s\n", static_cast<unsigned long long>(n), failure.c_str());
    sum.messages += swarm.totals().messages;
    sum.arrived += swarm.totals().arrived;
    sum.lost += swarm.totals().lost;
    sum.datagrams += swarm.totals().datagrams;
  }
  std::printf(
      "%llu networks, %llu failed; %llu messages, %llu arrived, %llu counted as lost; "
      "%llu datagrams\n",
      static_cast<unsigned long long>(count), static_cast<unsigned long long>(bad),
      static_cast<unsigned long long>(sum.messages), static_cast<unsigned long long>(sum.arrived),
      static_cast<unsigned long long>(sum.lost), static_cast<unsigned long long>(sum.datagrams));
  return bad == 0 ? Exit::kDone : Exit::kNo;
}

Exit run_storms(std::uint64_t seed, std::uint64_t count, bool verbose) {
  std::uint64_t bad = 0;
  std::uint64_t restarts = 0;
  std::uint64_t messages = 0;
  for (std::uint64_t n = seed; n < seed + count; ++n) {
    tims::sim::RestartStorm storm(n, verbose);
    const auto failures = storm.run();
    bad += failures.empty() ? 0 : 1;
    for (const std::string& failure : failures)
      std::printf("seed %llu: %s\n", static_cast<unsigned long long>(n), failure.c_str());
    restarts += storm.restarts();
    messages += storm.messages();
  }
  std::printf("%llu storms, %llu failed; %llu restarts, %llu messages\n",
              static_cast<unsigned long long>(count), static_cast<unsigned long long>(bad),
              static_cast<unsigned long long>(restarts), static_cast<unsigned long long>(messages));
  return bad == 0 ? Exit::kDone : Exit::kNo;
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t seed = 1;
  std::uint64_t count = 1;
  bool verbose = false;
  bool storms = false;
  timsctl::ArgumentParser parser("sim_swarm",
                                 "Simulates the networks of these seeds, as the test does.");
  parser.option("--seed", seed, "seed of the first network");
  parser.option("--count", count, "number of networks");
  parser.flag("--verbose", verbose, "print the events");
  parser.flag("--storms", storms, "networks whose routers are restarted again and again");
  return parser.run(argc, argv, [&] { return (storms ? run_storms : run)(seed, count, verbose); });
}
