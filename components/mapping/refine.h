// Matches all scans against all others that see the same walls, and optimises all poses; repeated,
// as each round starts with better poses. Pure.
//
// A scan is matched against each earlier or later pass of the same place: against the points of
// several scans together, which see more than one. It is not matched again against its own
// neighbours: they were placed by the same walls, and their errors are correlated. Matching them
// again bent the log aces by half a metre more in every round. As a scan and its neighbours see the
// same part of another pass, edges to passes count for a tenth.
#pragma once

#include "components/mapping/loops.h"

namespace rack::mapping {

// Improves the poses and returns the edges used. Nothing: stopped by `progress`.
std::optional<std::vector<Edge>> refine(Track& track, const Loops& loops, int rounds,
                                        const Progress& progress);

}  // namespace rack::mapping
