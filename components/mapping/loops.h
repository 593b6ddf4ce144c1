// Where a drive comes back to where it has been: loops are found, checked and closed. Pure.
//
// Each metre the scans of a stretch are searched for, together, beside all earlier stretches that
// they can be near (branch and bound, in a window that grows with the way since the last loop).
// What is found is believed only when the points lie on walls there, and when a second one, found
// some way on, says the same: a corridor with doors fits many places, but it does not fit twice in
// the same wrong place. Then the graph is optimised, and the search goes on with better poses.
#pragma once

#include "components/mapping/keyframes.h"

namespace rack::mapping {

struct Loops {
  std::vector<Edge> edges{};
  std::size_t tried = 0;
  std::size_t found = 0;
};

// Improves the poses of the track. Nothing: `progress` said so.
std::optional<Loops> close_loops(Track& track, const Progress& progress);

// The edges of the track, and of loops.
std::vector<Edge> all_edges(const Track& track, const Loops& loops);

}  // namespace rack::mapping
