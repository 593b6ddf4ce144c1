// Where a vehicle is on a path, truly: how far beside it, and what is ahead. Pure.
#pragma once

#include <optional>
#include <span>

#include "components/path/polar_spline.h"

namespace rack::dora {

struct Place {
  std::size_t spline = 0;
  double along = 0;   // on it, mm
  double across = 0;  // to the right of it, mm
};
// The nearest, of the same heading as far as there are several; nothing: there is no path.
std::optional<Place> place_on(std::span<const PolarSpline> path, const Pose& at);
// So much farther on; the end of the path when it is not that long.
Pose ahead_of(std::span<const PolarSpline> path, const Place& place, double way);
// To the end of the path, mm.
double rest_of(std::span<const PolarSpline> path, const Place& place);

}  // namespace rack::dora
