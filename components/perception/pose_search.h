// Finds the pose near a given one that fits best: steps along each of the three axes, halved when
// no step improves the fit (pattern search, Hooke and Jeeves 1961). Pure.
//
// The position is only as exact as odometry and localisation, and an error of half a degree is 90
// mm at 10 m: enough to see a wall twice. A scan is therefore aligned with the map or with earlier
// scans before it is compared with them. The error is a few steps at most. A step must improve the
// fit by a minimum, so that the pose does not slide along a corridor.
#pragma once

#include <array>
#include <cmath>

#include "components/geometry/pose.h"

namespace rack::perception {

struct PoseSearch {
  double step = 80;  // mm, of the first level
  double step_turn = radians(1.6);
  int levels = 4;            // each halves the step
  int steps_most = 4;        // per level
  double clear_part = 0.01;  // minimum improvement, as a share of the misfit
};

// `misfit`: function of a pose, to be minimised.
template <typename Misfit>
Pose nearest_fit(const Pose& start, const PoseSearch& search, const Misfit& misfit) {
  Pose best = start;
  double least = misfit(best);
  double step = search.step;
  double turn = search.step_turn;
  for (int level = 0; level < search.levels; ++level, step /= 2, turn /= 2) {
    for (int n = 0; n < search.steps_most; ++n) {
      const Pose from = best;
      const std::array<Pose, 6> steps{
          {{.x = step}, {.x = -step}, {.y = step}, {.y = -step}, {.rho = turn}, {.rho = -turn}}};
      double now = least * (1 - search.clear_part);
      bool better = false;
      for (const Pose& by : steps) {
        const Pose attempt = from + by;
        const double off = misfit(attempt);
        if (!(off < now)) continue;
        now = off;
        best = attempt;
        better = true;
      }
      if (!better) break;
      least = now;
    }
  }
  return best;
}

}  // namespace rack::perception
