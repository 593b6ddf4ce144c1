// The rectangle of which a scanner sees one or two sides (Zhang, Xu, Dong, Dolan: Efficient L-Shape
// Fitting for Vehicle Detection Using Laser Scanners, 2017). Pure.
//
// For each direction that the rectangle can have, within a quarter of a turn, the points are said
// along and across it, and each is nearest to one of the four sides that enclose all of them; the
// direction is taken for which the points are nearest to their sides (the criterion of closeness,
// which gives a wall's noise less weight than a missing corner). Directions are tried in coarse
// steps, then around the best in steps of a degree; of many points some are enough.
#pragma once

#include <span>

#include "components/geometry/floor_map.h"

namespace rack::perception {

struct Box {
  MapPoint centre{};
  double heading = 0;  // rad, of its first side: 0 to a quarter of a turn
  double length = 0;   // mm, along its first side
  double width = 0;    // mm, across it
};

// At least one point.
Box fit_box(std::span<const MapPoint> points);

}  // namespace rack::perception
