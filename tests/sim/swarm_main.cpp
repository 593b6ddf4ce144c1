// sim_swarm: simulates random networks, as the test does.
#include <string>

#include <fmt/format.h>

#include "tests/sim/restart_storm.h"
#include "tests/sim/swarm.h"
#include "tools/cli/argument_parser.h"

namespace {

using timsctl::Exit;

struct Seeds {
  std::uint64_t first = 1;
  std::uint64_t count = 1;
  bool verbose = false;
};

// Prints what fails, and returns the number of seeds of which something did. `add` takes each
// simulation.
template <typename Simulation, typename Add>
std::uint64_t failed(const Seeds& seeds, Add add) {
  std::uint64_t bad = 0;
  for (std::uint64_t seed = seeds.first; seed < seeds.first + seeds.count; ++seed) {
    Simulation simulation(seed, seeds.verbose);
    const auto failures = simulation.run();
    bad += failures.empty() ? 0 : 1;
    for (const std::string& failure : failures) fmt::print("seed {}: {}\n", seed, failure);
    add(simulation);
  }
  return bad;
}

Exit run_swarms(const Seeds& seeds) {
  tims::sim::SwarmTotals sum;
  const std::uint64_t bad = failed<tims::sim::Swarm>(seeds, [&](const tims::sim::Swarm& swarm) {
    sum.messages += swarm.totals().messages;
    sum.arrived += swarm.totals().arrived;
    sum.lost += swarm.totals().lost;
    sum.datagrams += swarm.totals().datagrams;
  });
  fmt::print("{} networks, {} failed; {} messages, {} arrived, {} counted as lost; {} datagrams\n",
             seeds.count, bad, sum.messages, sum.arrived, sum.lost, sum.datagrams);
  return bad == 0 ? Exit::kDone : Exit::kNo;
}

Exit run_storms(const Seeds& seeds) {
  std::uint64_t restarts = 0;
  std::uint64_t messages = 0;
  const std::uint64_t bad =
      failed<tims::sim::RestartStorm>(seeds, [&](const tims::sim::RestartStorm& storm) {
        restarts += storm.restarts();
        messages += storm.messages();
      });
  fmt::print("{} storms, {} failed; {} restarts, {} messages\n", seeds.count, bad, restarts,
             messages);
  return bad == 0 ? Exit::kDone : Exit::kNo;
}

}  // namespace

int main(int argc, char** argv) {
  Seeds seeds;
  bool storms = false;
  timsctl::ArgumentParser parser("sim_swarm",
                                 "Simulates the networks of these seeds, as the test does.");
  parser.option("--seed", seeds.first, "seed of the first network");
  parser.option("--count", seeds.count, "number of networks");
  parser.flag("--verbose", seeds.verbose, "print the events");
  parser.flag("--storms", storms, "networks whose routers are restarted again and again");
  return parser.run(argc, argv, [&] { return (storms ? run_storms : run_swarms)(seeds); });
}
