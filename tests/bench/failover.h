// Effect of a cut of UDP on messages between two routers that also have DDS.
#pragma once

#include "tests/bench/crew.h"

namespace tims::bench {

// Measures the longest latency around the cut and around the restoration, the seconds from the
// restoration of UDP until both routers use it again, and the lost messages.
Result<Metrics> measure_failover(const Crew& crew);

}  // namespace tims::bench
