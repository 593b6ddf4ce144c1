// Fits a rectangle to points on one or two of its sides (Zhang, Xu, Dong, Dolan: Efficient L-Shape
// Fitting for Vehicle Detection Using Laser Scanners, 2017). Pure.
//
// For each candidate direction within a quarter of a turn, the points are projected onto the
// direction and its normal, and each point is assigned to the nearest of the four sides that
// enclose all points. The direction with the smallest distances between points and sides wins (the
// closeness criterion, which weighs the noise of a wall less than a missing corner). Directions are
// tried in coarse steps, then around the best one in steps of a degree; of many points a subset is
// used.
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
