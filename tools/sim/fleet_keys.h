// The keys of a simulated fleet: an authority at the base, a certificate for each host.
#pragma once

#include "tools/sim/plan.h"

namespace timsctl::sim {

// Makes the folder keys() of each host, for the router that its plan describes. Throws Failure.
void make_keys(const Plan& plan);

}  // namespace timsctl::sim
