// The plan's namespaces and cables, made real; and the quality of the cables.
#pragma once

#include <string>
#include <vector>

#include "tools/timsctl/sim/plan.h"

namespace timsctl::sim {

class Network {
 public:
  explicit Network(const Plan& plan) : plan_(plan) {}

  void make();  // throws Failure
  // What the kernel does of it; the routers do the rest (router_faults).
  void apply(const Line& line, const LineState& before, const LineState& state) const;
  // Can the kernel delay, double and reorder by itself?
  [[nodiscard]] bool netem() const { return netem_; }

 private:
  void apply(const LineEnd& sender, const LineEnd& receiver, const Quality& before,
             const Quality& quality) const;

  const Plan& plan_;
  bool netem_ = false;
};

// Namespaces of that fleet which are there, whoever made them.
std::vector<std::string> networks_of(std::string_view fleet);
// Ends what runs in them, and takes them away.
void remove_networks(const std::vector<std::string>& networks);

}  // namespace timsctl::sim
