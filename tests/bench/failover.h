// What a cut of UDP does to messages between two routers that have DDS besides.
#pragma once

#include "tests/bench/crew.h"

namespace tims::bench {

// The longest that a message took around the cut, and around the return; seconds from the return of
// UDP until both use it again; messages lost.
Result<Metrics> measure_failover(const Crew& crew);

}  // namespace tims::bench
