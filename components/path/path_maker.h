// From waypoints to a path: lines, with arcs where the route bends, and how fast each may be
// driven. Pure.
//
// The waypoints are joined by straight legs. Each bend is rounded by an arc that touches both legs
// (a fillet). Its radius is the one at which the vehicle needs not slow down, as far as there is
// room: the arc takes R tan(d/2) of each leg, where d is the angle of the bend, and two bends share
// the leg between them; it cuts the corner by R (1 / cos(d/2) - 1), which has to stay within the
// corridor. A radius below the vehicle's smallest is an error, for which a person has to move
// waypoints; one who turns at rest has none, and stops in a corner that cannot be rounded. Where
// the vehicle changes between forward and backward, it stops, and goes on with an arc from the
// heading it has. Then the speeds: each spline gets the least of what the waypoint, the vehicle's
// turning speed and its lateral acceleration allow; a pass along the path lets the speed grow no
// faster than accMax, one against it lets it fall no faster than decMax. (Textbook: Choset et al.,
// Principles of Robot Motion; time scaling with forward and backward pass: Bobrow et al. 1985.)
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
  double radius_min = 0;               // mm; 0: it turns at rest
  double half_width = 0;               // of the vehicle, kept inside of the corridor, mm
  double corridor = 500;               // to each side, for waypoints that say none, mm
};

// Says what is no limit: not positive, or no number.
tims::Result<void> check(const PathLimits& limits);

// A waypoint's speed is a limit; below 10 mm/s it says only whether the leg to it is driven forward
// or backward, as the original's graphical interface sends it. `start`: the heading with which the
// path begins; none: that of the first leg.
//
//   kInvalidArgument  says at which waypoint the route cannot be driven, and why
//   kTooBig           more than kSplinesMax splines
tims::Result<std::vector<PolarSpline>> make_path(std::span<const Waypoint2d> waypoints,
                                                 const PathLimits& limits,
                                                 const double* start_heading = nullptr);

// Of splines whose geometry, vMax, accMax and decMax are there: vStart and vEnd. The path ends at
// rest.
void set_speeds(std::span<PolarSpline> splines, double start_speed = 0);

// vMax, accMax and decMax of a spline: what the vehicle can do there, and no more than `wish`,
// mm/s.
void limit_speed(PolarSpline& spline, const PathLimits& limits, double wish);

}  // namespace rack::path
