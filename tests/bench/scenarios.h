// The scenarios: for each scenario and payload the processes, the metrics shown with their limits,
// and the targets.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/bench/experiment.h"

namespace tims::bench {

struct Target {
  std::optional<double> ratio_max{};  // times worse than the limit
  std::optional<double> at_least{};
  std::optional<double> at_most{};
  std::optional<double> above_max{};  // difference to the reference
};

// A row of the table.
struct Row {
  std::string peer;
  std::string metric;
  std::string limit;  // the reference peer; empty: none
  Target target{};
};

struct Contender {
  std::string peer;
  Experiment experiment;
  bool in_csv = true;
};

struct Case {
  std::string scenario;
  std::size_t payload = 0;
  std::vector<Contender> contenders{};
  std::vector<Row> rows{};
};

struct ScenarioText {
  const char* name;
  const char* text;
};

std::vector<ScenarioText> scenario_texts();
// All cases in the order in which they run: on this host, then between two hosts.
std::vector<Case> local_cases(bool quick);
std::vector<Case> devices_cases(bool quick);
std::vector<Case> hosts_cases(bool quick);

}  // namespace tims::bench
