// One process of a measurement.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// Opens the link, prints "ready", runs the role, prints the metrics. False: an error was printed to
// stderr.
bool run_role(const Plan& plan);

}  // namespace tims::bench
