// The walls of a map of cells as lines: the outlines of the groups of occupied cells, simplified.
// Pure.
//
// An outline follows the borders of cells with the occupied ones on its left; cells that touch at a
// corner belong to one group, so that a diagonal wall has one outline. On the border of a straight
// wall, all runs in one of the two directions have length 1; the middles of these runs are on a
// straight line, also at the ends of a wall of one cell, which so becomes a line in its middle. The
// points of an outline are these middles, and the corners between longer runs. Simplification
// joins points to lines: it keeps the sector of directions that pass all points so far within the
// tolerance, and ends the line before the sector becomes empty (after Zhao and Saalfeld,
// Linear-time sleeve-fitting polyline simplification algorithms, 1997).
#pragma once

#include <cstddef>
#include <vector>

#include "components/localisation/grid_map.h"
#include "tims/result.h"

namespace rack::localisation {

struct Outlines {
  std::vector<MapLine> lines{};
  double error = 0;        // mm: the maximum distance of an outline from the border of its cells
  bool is_coarse = false;  // it was increased
};

// At most `lines_max` lines: with too many, the tolerance is increased, up to 3 cells. Errors: no
// occupied cells; still too many lines.
tims::Result<Outlines> outlines(const GridMap& map, std::size_t lines_max);

inline constexpr std::size_t kOutlineCornersMax = 8'000'000;  // of all outlines

}  // namespace rack::localisation
