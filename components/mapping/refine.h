// All scans on all that see the same walls, and all poses to where these agree best; again and
// again, as each round begins with better poses. Pure.
//
// A scan is matched with each earlier or later pass of the same place: as points of several scans
// together, which see more than one. It is not matched again with its own neighbours: they were
// placed beside each other by the same walls and err with it, the same way from scan to scan. That
// once more, and believed, bent aces by half a metre more with every round; and as a scan and its
// neighbours see the same of another pass, what passes say counts for a tenth.
#pragma once

#include "components/mapping/loops.h"

namespace rack::mapping {

// Improves the poses; the edges that it did so by. Nothing: `progress` said so.
std::optional<std::vector<Edge>> refine(Track& track, const Loops& loops, int rounds,
                                        const Progress& progress);

}  // namespace rack::mapping
