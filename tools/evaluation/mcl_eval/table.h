// Requirements of the localiser on three public logs (aces, intel, fr079): limit, measured value
// and verdict. Pure except for the stopwatch.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/evaluation/mcl_eval/evaluation.h"

namespace rack::mcl_eval {

// A recorded drive with map and ground truth; poses or relations may be empty.
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

// Calls `print` with each row as soon as it is measured. Returns false if a requirement did not
// hold. Each row uses `seeds` runs, with seeds 1, 2 ...
bool measure(const std::vector<Recording>& recordings, std::uint32_t seeds, bool scan_matching,
             const Stopwatch& stopwatch, const std::function<void(const Row&)>& print);

}  // namespace rack::mcl_eval
