// Roles of components: a scanner that publishes, listeners that are woken by it, and one that only
// keeps time.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

inline constexpr int kRealTimePriority = 80;

// A DataModule: 361 points each `plan.every`, until its listeners have had enough. Its CPU time in
// percent of one core, since the last listener came.
bool play_scanner(const Plan& plan);
// Turns the scanner on and takes its data for `plan.seconds`: how long from put to here.
bool play_listener(const Plan& plan);
// A DataModule of real-time priority, with a period of 1 ms: how late it is woken.
bool play_clockwork(const Plan& plan);
// One of those that are in its way.
bool burn(const Plan& plan);

}  // namespace tims::bench
