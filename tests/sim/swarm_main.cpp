// sim_swarm [--seed N] [--count N] [--verbose]: simulates the networks of these
// seeds, as the test does.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/sim/swarm.h"

int main(int argc, char** argv) {
  std::uint64_t seed = 1;
  std::uint64_t count = 1;
  bool verbose = false;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const auto number = [&] { return i + 1 < argc ? std::strtoull(argv[++i], nullptr, 10) : 0; };
    if (option == "--seed") seed = number();
    if (option == "--count") count = number();
    if (option == "--verbose") verbose = true;
  }
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
  return bad == 0 ? 0 : 1;
}
