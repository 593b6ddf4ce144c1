// What a simulation finds to be wrong, and, if asked for, prints of its events.
#pragma once

#include <string>
#include <vector>

#include "tests/sim/simulated_network.h"

namespace tims::sim {

class Findings {
 public:
  Findings(const SimulatedNetwork& network, bool verbose) : network_(network), verbose_(verbose) {}

  void fail(const std::string& what);         // the first 20 are kept
  void print(const std::string& what) const;  // with the time, if verbose
  [[nodiscard]] bool is_verbose() const { return verbose_; }
  [[nodiscard]] const std::vector<std::string>& failures() const { return failures_; }

 private:
  const SimulatedNetwork& network_;
  const bool verbose_;
  std::vector<std::string> failures_;
};

}  // namespace tims::sim
