// Splines: the lines and arcs of a path (specification, section 9.0). Pure.
//
// A spline has a start pose and a length. Lines have radius 0. The centre of an arc is to the right
// for a positive radius. The sign of the length is the sense of travel: a negative one is driven
// backward, while the headings remain those of the vehicle. So the heading on an arc is always that
// of the start plus the distance divided by the radius, with all signs. The position of a vehicle
// relative to a spline uses the original's coordinates: x along it, y to the right of it, rho to
// the right of its heading; centerPos is the frame they are measured in, as the original's programs
// expect it.
#pragma once

#include "components/geometry/pose.h"
#include "rack/proxies/path.h"

namespace rack::path {

// A pose relative to a spline, in mm and rad. `along` is negative on a spline that is driven
// backward.
struct Beside {
  double along = 0;
  double across = 0;
  double turned = 0;
};

// Starts at that pose; a negative length is driven backward. Only the geometry is set.
PolarSpline line(const Pose& from, double length);
PolarSpline arc(const Pose& from, i32 radius, double length);

// The pose on the spline at `along`, which has the sign of its length; beyond its ends the spline
// is continued.
Pose pose_at(const PolarSpline& spline, double along);
// On arcs, up to half a turn before the start is behind, the rest is ahead of it.
Beside beside(const PolarSpline& spline, const Pose& at);

// 1/mm, positive to the right.
inline double curvature(const PolarSpline& spline) {
  return spline.radius == 0 ? 0 : 1.0 / spline.radius;
}
inline double size(const PolarSpline& spline) {
  return std::abs(static_cast<double>(spline.length));
}
inline double sense(const PolarSpline& spline) { return spline.length < 0 ? -1 : 1; }

// Whether the vehicle must not drive here: it makes room for somebody, and waits at the start of
// this spline until it gets another path.
inline bool is_waiting(const PolarSpline& spline) { return spline.vMax == 0; }

// Whether the vehicle can pass from one spline to the next without a stop: same sense, no corner.
bool runs_on(const PolarSpline& from, const PolarSpline& to);

// The speed after `distance` mm of the spline, mm/s: follows the speeds at its ends within accMax,
// decMax, vMax.
double speed_at(const PolarSpline& spline, double distance);

}  // namespace rack::path
