// Round an obstacle on a path and back to it. Pure.
//
// A detour leaves the path where the vehicle is and comes back to it behind the obstacle, at the
// first of some places where there is room. Between them it may go wherever the corridor of the
// path is: what lies outside of it counts as occupied, and a planner does the rest.
#pragma once

#include <span>
#include <vector>

#include "components/path/free_space.h"
#include "components/path/polar_spline.h"

namespace rack::path {

struct OnPath {
  std::size_t index = 0;  // of the spline
  double way = 0;         // on it, mm
};

// So much further along the path, or at its end.
OnPath further(std::span<const PolarSpline> path, const OnPath& from, double distance);
Pose pose_on(std::span<const PolarSpline> path, const OnPath& at);
// What is left of the path from there on, at the end of `to`; what does not fit is left out.
void append_rest(std::span<const PolarSpline> path, const OnPath& from,
                 std::vector<PolarSpline>& to);

// Only cells in the corridors of these splines stay free, and those near a place.
void keep_to_corridor(FreeSpace& space, std::span<const PolarSpline> splines, const Place& near,
                      double distance);

}  // namespace rack::path
