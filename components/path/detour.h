// Detours around an obstacle and back to the path. Pure.
//
// A detour leaves the path at the vehicle and returns to it behind the obstacle, at the first of
// several candidate places with enough room. In between, the whole corridor of the path may be
// used: space outside of it counts as occupied, and a planner finds the detour.
#pragma once

#include <span>
#include <vector>

#include "components/path/free_space.h"
#include "components/path/polar_spline.h"

namespace rack::path {

struct OnPath {
  std::size_t index = 0;  // of the spline
  double distance = 0;    // distance from its start, mm
};

// The place `distance` further along the path, or its end.
OnPath further(std::span<const PolarSpline> path, const OnPath& from, double distance);
Pose pose_on(std::span<const PolarSpline> path, const OnPath& at);
// Appends the rest of the path from `from` on to `to`, as far as there is capacity.
void append_rest(std::span<const PolarSpline> path, const OnPath& from,
                 std::vector<PolarSpline>& to);

// Occupies all cells except those in the corridors of these splines and those within `distance` of
// `near`.
void keep_to_corridor(FreeSpace& space, std::span<const PolarSpline> splines, const Place& near,
                      double distance);

}  // namespace rack::path
