// What a seed determines: a tree of routers, and which kinds of faults occur.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/sim/simulated_network.h"

namespace tims::sim {

// The seed switches each kind of fault on or off for the whole run, so that some networks have many
// faults of one kind and none of the others (swarm testing, Groce et al. 2012).
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
  bool dds = false;        // some links use DDS as first, second or only path
  bool half_cuts = false;  // with dds: cuts one path at a time of links with two

  [[nodiscard]] std::string to_string() const;
  // Only faults that links must mask completely: no message may be lost.
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
  std::vector<PlannedLink> with_two_paths{};  // links with UDP and DDS at both ends
  bool has_single_routes = true;              // one route between any two nodes

  // The path from `node` up over the preferred super routers, starting with itself.
  [[nodiscard]] std::vector<std::size_t> up_from(std::size_t node) const;
  [[nodiscard]] bool is_below(std::size_t node, std::size_t top) const;
  // The routers a message passes, both ends included; empty: there is no route.
  [[nodiscard]] std::vector<std::size_t> route(std::size_t from, std::size_t to) const;
  [[nodiscard]] std::string to_string() const;
};

Plan make_plan(SimulatedNetwork& network);
Faults make_faults(SimulatedNetwork& network, const Troubles& troubles);
// The same for DDS: in order, slower, with losses less often.
Faults make_dds_faults(SimulatedNetwork& network, const Troubles& troubles);

}  // namespace tims::sim
