// From waypoints to a path: lines, with arcs in the bends, and the speed of each. Pure.
//
// The waypoints are joined by straight legs. Each bend is rounded by an arc that touches both legs
// (a fillet). Its radius is the one at which the vehicle need not slow down, if there is room: the
// arc takes R tan(d/2) of each leg, where d is the angle of the bend, and two bends share the leg
// between them; it cuts the corner by R (1 / cos(d/2) - 1), which must stay within the corridor. A
// radius below the minimum of the vehicle is an error, and the user has to move waypoints; a
// vehicle that turns at rest has no minimum, and stops in a corner that cannot be rounded. Where
// the vehicle changes between forward and backward, it stops, and continues with an arc from its
// heading. The speed of each spline is the minimum of the limits by the waypoint, the vehicle's
// angular speed and its lateral acceleration; a forward pass along the path limits the increase to
// accMax, a backward pass the decrease to decMax. (Textbook: Choset et al., Principles of Robot
// Motion; time scaling with forward and backward pass: Bobrow et al. 1985.)
#pragma once

#include <span>
#include <vector>

#include "components/path/polar_spline.h"
#include "tims/result.h"

namespace rack::path {

inline constexpr std::size_t kSplinesMax = 6000;

struct PathLimits {
  double speed_max = 1000;             // mm/s
  double backward_max = 500;           // mm/s
  double acceleration = 500;           // mm/s2
  double deceleration = 500;           // mm/s2
  double omega_max = 0.35;             // rad/s
  double lateral_acceleration = 1000;  // mm/s2
  double radius_min = 0;               // mm; 0: the vehicle turns at rest
  double half_width = 0;               // of the vehicle, which stays in the corridor, mm
  double corridor = 500;               // to each side, for waypoints without one, mm
};

// Error: a limit is not positive, or not a number.
tims::Result<void> check(const PathLimits& limits);

// A waypoint's speed is a limit; below 10 mm/s it only selects forward or backward for the leg to
// it, as the original's graphical interface sends it. `start_heading`: the heading at the start of
// the path; nullptr: that of the first leg.
//
//   kInvalidArgument  names the waypoint where the route cannot be driven, and the reason
//   kTooBig           more than kSplinesMax splines
tims::Result<std::vector<PolarSpline>> make_path(std::span<const Waypoint2d> waypoints,
                                                 const PathLimits& limits,
                                                 const double* start_heading = nullptr);

// Sets vStart and vEnd of splines whose geometry, vMax, accMax and decMax are set. The path ends at
// rest.
void set_speeds(std::span<PolarSpline> splines, double start_speed = 0);

// Sets vMax, accMax and decMax of a spline to the limits of the vehicle, and vMax to at most
// `target`, mm/s.
void limit_speed(PolarSpline& spline, const PathLimits& limits, double target);

}  // namespace rack::path
