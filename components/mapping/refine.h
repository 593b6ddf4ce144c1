// All scans on all that see the same walls, and all poses to where these agree best; again and
// again, as each round begins with better poses. Pure.
//
// A scan is matched with the stretch before it, the stretch behind it, and with each earlier or
// later pass of the same place: as points of several scans together, which see more than one. What
// was only odometry or a first match gives way to what all of the map says.
#pragma once

#include "components/mapping/loops.h"

namespace rack::mapping {

// Improves the poses; the edges that it did so by. Nothing: `progress` said so.
std::optional<std::vector<Edge>> refine(Track& track, const Loops& loops, int rounds,
                                        const Progress& progress);

}  // namespace rack::mapping
