// What a seed stands for: a tree of routers, and which kinds of trouble it is in.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/sim/simulated_network.h"

namespace tims::sim {

// Trouble is switched on and off as a whole by the seed, so that some networks have much of one
// kind and none of the others (swarm testing, Groce et al. 2012).
struct Troubles {
  bool loss = false;
  bool duplicates = false;
  bool reordering = false;
  bool delay = false;
  bool jitter = false;
  bool rates = false;
  bool mtus = false;
  bool partitions = false;
  bool crashes = false;
  bool moves = false;
  bool churn = false;  // clients come and go
  bool wall_jumps = false;
  bool large = false;    // messages of 2 MB
  bool samples = false;  // messages with flag STREAM
  bool small_queues = false;
  bool short_lifetimes = false;
  bool little_memory = false;
  bool dds = false;        // some links have it, as the first way, the other or the only one
  bool half_cuts = false;  // then: one way of a link that has both is cut at a time

  [[nodiscard]] std::string to_string() const;
  // Nothing that a link could not hide.
  [[nodiscard]] bool are_mild() const {
    return !loss && !partitions && !crashes && !moves && !churn && !small_queues &&
           !short_lifetimes && !little_memory && !rates;
  }
};

struct PlannedLink {
  std::size_t lower = 0;
  std::size_t upper = 0;
};

struct PlannedNode {
  NodeSetup setup{};
  std::vector<std::size_t> supers{};  // in order of preference
  std::vector<std::size_t> peers{};   // both directions
};

struct Plan {
  Troubles troubles{};
  std::vector<PlannedNode> nodes{};
  std::vector<PlannedLink> both_ways{};  // that have UDP and DDS at both ends
  bool one_way_only = true;              // between any two nodes

  // From `node` up over the preferred super routers, itself first.
  [[nodiscard]] std::vector<std::size_t> up_from(std::size_t node) const;
  [[nodiscard]] bool is_below(std::size_t node, std::size_t top) const;
  // The routers a message passes, both ends included; empty: there is no way.
  [[nodiscard]] std::vector<std::size_t> way(std::size_t from, std::size_t to) const;
  [[nodiscard]] std::string to_string() const;
};

Plan make_plan(SimulatedNetwork& network);
Faults make_faults(SimulatedNetwork& network, const Troubles& troubles);
// What DDS makes of it: in order, seldom with losses, slower.
Faults make_dds_faults(SimulatedNetwork& network, const Troubles& troubles);

}  // namespace tims::sim
