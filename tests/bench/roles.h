// One process of a measurement.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// Opens the link, says "ready", plays the role, prints what was measured. False: it went wrong, and
// stderr says how.
bool run_role(const Plan& plan);

}  // namespace tims::bench
