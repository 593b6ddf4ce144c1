// The policy alone: the time of a verdict.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// ns per verdict on messages to plan.count mailboxes, by 100 rules of which the last decides.
bool measure_verdicts(const Plan& plan);

}  // namespace tims::bench
