// The pose near a given one that fits best: a search by steps along each of its three axes, which
// are halved when none of them is better (pattern search, Hooke and Jeeves 1961). Pure.
//
// A position is as good as odometry and localisation are, and half a degree of it is 90 mm at 10 m:
// enough for a wall to stand beside itself. Before a scan is compared with the map or with earlier
// scans it is therefore laid on them. What it may be wrong by is a few steps; where nothing is
// better by a clear part it stays, so that it does not slide along a corridor.
#pragma once

#include <array>
#include <cmath>

#include "components/geometry/pose.h"

namespace rack::perception {

struct PoseSearch {
  double step = 80;  // mm, the first
  double step_turn = radians(1.6);
  int levels = 4;            // each half as wide
  int steps_most = 4;        // on each of them
  double clear_part = 0.01;  // of the misfit: less is no better
};

// `misfit`: of a pose, the less the better.
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
