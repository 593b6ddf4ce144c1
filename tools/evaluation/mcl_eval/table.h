// What the localiser must reach on the three public logs (aces, intel, fr079), as a table: what is
// wanted, what was measured, and whether it held. Pure but for the stopwatch.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/evaluation/mcl_eval/evaluation.h"

namespace rack::mcl_eval {

// A recorded drive with all that is known of it; one of the truths may be empty.
struct Recording {
  std::string name{};
  localisation::CarmenLog log{};
  localisation::LikelihoodField field;
  localisation::WallLines walls{};
  Truth poses{};
  Truth relations{};
};

struct Row {
  std::string what{};
  std::string wanted{};
  std::string measured{};
  bool held = false;
};

// Rows are handed over as soon as they are known; false: one of them did not hold. `seeds` runs
// each, with seeds 1, 2 ...
bool measure(const std::vector<Recording>& recordings, std::uint32_t seeds, bool scan_matching,
             const Stopwatch& stopwatch, const std::function<void(const Row&)>& print);

}  // namespace rack::mcl_eval
