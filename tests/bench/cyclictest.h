// The standard program that measures the wake-up delay of a real-time thread.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

[[nodiscard]] bool has_cyclictest();  // Debian: rt-tests

// Runs with period `plan.every` for `plan.seconds`, with the priority and CPU of the clockwork
// role.
bool run_cyclictest(const Plan& plan);

}  // namespace tims::bench
