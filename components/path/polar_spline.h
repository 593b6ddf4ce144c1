// Splines: the lines and arcs that paths are made of (specification, section 9.0). Pure.
//
// A spline says where the vehicle is and looks at its start, and how far it goes from there. Lines
// have radius 0. An arc turns about its centre, which is to the right for a positive radius. Its
// sense of travel is the sign of the length: a negative one is driven backward, while the headings
// are still those of the vehicle. So a heading on an arc is always that of the start plus the way
// divided by the radius, whatever the signs are. Where a vehicle is beside a spline is said in the
// original's coordinates: x along it, y to the right of it, rho to the right of its heading;
// centerPos holds the frame they are measured in, as the original's programs expect it.
#pragma once

#include "components/geometry/pose.h"
#include "rack/proxies/path.h"

namespace rack::path {

// Seen from a spline, in mm and rad. Along a spline that is driven backward is negative.
struct Beside {
  double along = 0;
  double across = 0;
  double turned = 0;
};

// From that pose; a length below 0 goes backward. Only the geometry is filled in.
PolarSpline line(const Pose& from, double length);
PolarSpline arc(const Pose& from, i32 radius, double length);

// A point of it, `along` of the sign of its length; beyond its ends it goes on.
Pose pose_at(const PolarSpline& spline, double along);
// Arcs: up to half a turn before their start, the rest is ahead of it.
Beside beside(const PolarSpline& spline, const Pose& at);

// 1/mm, positive to the right.
inline double curvature(const PolarSpline& spline) {
  return spline.radius == 0 ? 0 : 1.0 / spline.radius;
}
inline double size(const PolarSpline& spline) {
  return std::abs(static_cast<double>(spline.length));
}
inline double sense(const PolarSpline& spline) { return spline.length < 0 ? -1 : 1; }

// Whether the vehicle can go from one to the next without a stop: in the same sense, and without a
// corner.
bool runs_on(const PolarSpline& from, const PolarSpline& to);

// mm/s, after so many mm of it: between the speeds at its ends it keeps to accMax, decMax, vMax.
double speed_at(const PolarSpline& spline, double way);

}  // namespace rack::path
