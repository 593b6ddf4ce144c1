// Finds, checks and closes loops: places where a drive comes back to an earlier one. Pure.
//
// Every metre, the scans of a stretch are matched together against all earlier stretches that may
// be near (branch and bound, in a window that grows with the distance since the last loop). A match
// is accepted only when its points are on walls there, and a second match, found some distance
// later, agrees: a corridor with doors fits many places, but not twice at the same wrong place.
// Then the graph is optimised, and the search continues with better poses.
#pragma once

#include "components/mapping/keyframes.h"

namespace rack::mapping {

struct Loops {
  std::vector<Edge> edges{};
  std::size_t tried = 0;
  std::size_t found = 0;
};

// Improves the poses of the track. Nothing: stopped by `progress`.
std::optional<Loops> close_loops(Track& track, const Progress& progress);

// The edges of the track and of the loops.
std::vector<Edge> all_edges(const Track& track, const Loops& loops);

}  // namespace rack::mapping
