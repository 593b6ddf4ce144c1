// A robot of twelve components.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// Seconds from the start of `timsctl up` until all of them are on.
bool start_robot(const Plan& plan);

}  // namespace tims::bench
