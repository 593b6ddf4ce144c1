// The true position of a vehicle relative to its path: distance along the path and cross-track
// error. Pure.
#pragma once

#include <optional>
#include <span>

#include "components/path/polar_spline.h"

namespace rack::dora {

// A position in path coordinates.
struct PathPosition {
  std::size_t spline = 0;  // index in the path
  double along = 0;        // distance from the start of the spline, mm
  double across = 0;       // cross-track error, mm; positive to the right of the path
};
// Projects a pose onto the nearest point of the path. Where the path crosses itself or returns
// close to itself, the segment with the more similar heading is preferred. Empty if the path is.
std::optional<PathPosition> project_onto(std::span<const PolarSpline> path, const Pose& at);
// The pose on the path `distance` mm beyond `position`, or the end of the path if it is nearer.
Pose ahead_of(std::span<const PolarSpline> path, const PathPosition& position, double distance);
// The length of the path beyond `position`, mm.
double remaining_length(std::span<const PolarSpline> path, const PathPosition& position);

}  // namespace rack::dora
