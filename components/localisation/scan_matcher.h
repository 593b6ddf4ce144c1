// The last centimetres: an estimate of the particle filter, and the whole scan laid on the walls of
// the map from there. Pure.
//
// A filter is made to survive: a scan counts in it as a few beams, and 500 particles lie some
// centimetres apart. Here all beams count for what they tell, but only near where the filter is:
// its covariance pulls at the pose as one more measurement, and a pose that is farther away than it
// allows is refused; so is one where half of the points fit no wall, or fit badly. Along a corridor
// it says nothing, and what the filter knows stays. The filter itself learns nothing from the
// result, so it can neither be lost by it nor become too sure.
//
// The covariance is that of both together. How much points err is measured by the scan itself:
// ranges, the map's walls, and neighbours that err together.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "components/localisation/line_match.h"
#include "components/localisation/particle_filter.h"
#include "components/localisation/wall_lines.h"

namespace rack::localisation {

class ScanMatcher {
 public:
  ScanMatcher();

  // Nothing: the scan says nothing that can be believed. `scan` in the frame of the robot, in the
  // order in which it was made. Allocates nothing.
  [[nodiscard]] std::optional<Estimate> refined(const WallLines& walls,
                                                std::span<const BeamEnd> scan,
                                                const Estimate& estimate);

 private:
  std::vector<ScanPoint2d> points_;
};

}  // namespace rack::localisation
