// The usual program that tells how late a thread of real-time priority is woken.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

[[nodiscard]] bool has_cyclictest();  // Debian: rt-tests

// With `plan.every` as period, for `plan.seconds`, at the priority and on the CPU of the clockwork.
bool run_cyclictest(const Plan& plan);

}  // namespace tims::bench
