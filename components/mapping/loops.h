// Finds, checks and closes loops: places where a drive comes back to an earlier one. Pure.
//
// Every metre, the scans of a stretch are matched together against all earlier stretches that may
// be near: as far as the uncertainty that has grown since (uncertainty.h), by branch and bound. A
// match is accepted when its points are on walls there, when no scan of either stretch sees through
// walls of the other (view.h), and when other matches, found some distance later, agree: a corridor
// with doors fits many places. The larger the window, the longer is the stretch and the more is
// asked: nothing else in the window may fit about as well, and more matches must agree than agree
// on any other place. Then the graph is optimised, and the search continues with better poses.
//
// At the end loops are checked with the final poses, wrong ones are removed, and the drive is
// searched again for loops that were missed while the poses were worse.
#pragma once

#include "components/mapping/keyframes.h"

namespace rack::mapping {

struct Loops {
  std::vector<Edge> edges{};
  std::size_t tried = 0;
  std::size_t found = 0;
  std::size_t removed = 0;  // accepted at first, contradicted later
};

// Improves the poses of the track. Nothing: stopped by `progress`.
std::optional<Loops> close_loops(Track& track, const Progress& progress);

// The edges of the track and of the loops.
std::vector<Edge> all_edges(const Track& track, const Loops& loops);

}  // namespace rack::mapping
