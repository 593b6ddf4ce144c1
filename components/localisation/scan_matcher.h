// Refines an estimate of the particle filter by matching the whole scan against the walls of the
// map. Pure.
//
// A particle filter is designed for robustness: a scan counts as a few beams in it, and 500
// particles are some centimetres apart. Here all beams count, but only near the estimate of the
// filter: its covariance enters as a prior, and a pose that is farther away than it allows is
// rejected; so is one where half of the points fit no wall, or fit badly. Along a corridor the
// match has no information, and the estimate of the filter stays. The result is not fed back into
// the filter, so it can neither make the filter lose the robot nor make it overconfident.
//
// The covariance combines both. The error of points is estimated from the scan itself: it includes
// range noise, the map's walls, and correlated errors of neighbours.
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

  // Nothing: the match is not reliable. `scan`: in the frame of the robot, in the order of
  // measurement. Allocates nothing.
  [[nodiscard]] std::optional<Estimate> refined(const WallLines& walls,
                                                std::span<const BeamEnd> scan,
                                                const Estimate& estimate);

 private:
  std::vector<ScanPoint2d> points_;
};

}  // namespace rack::localisation
