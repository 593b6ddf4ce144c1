// Roles of components: a scanner that publishes, listeners that it wakes, and a component that only
// measures its wake-up times.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

inline constexpr int kRealTimePriority = 80;

// A DataModule: 361 points every `plan.every`, until its listeners have enough. Prints its CPU time
// in percent of one core, from the last subscription on.
bool play_scanner(const Plan& plan);
// Turns the scanner on and receives its data for `plan.seconds`; prints the latency from put.
bool play_listener(const Plan& plan);
// A DataModule of real-time priority with a period of 1 ms; prints the delay of its wake-ups.
bool play_clockwork(const Plan& plan);
// A process that loads a CPU.
bool burn(const Plan& plan);

}  // namespace tims::bench
