// A flood of forged HELLOs at a router, as everybody on the network can send them.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// Sends `plan.count` HELLOs a second to the base, each with another token, alternately of links
// with and without keys, for the time of a measurement; prints how many went out a second.
bool send_hello_flood(const Plan& plan);

}  // namespace tims::bench
