#include "tools/evaluation/dora/cross_track.h"

#include <algorithm>
#include <cmath>

namespace rack::dora {

std::optional<PathPosition> project_onto(std::span<const PolarSpline> path, const Pose& at) {
  // A heading difference of one radian costs as much as this distance, mm: the path may return
  // close to itself in another direction.
  constexpr double kPerRadian = 3000;
  std::optional<PathPosition> best;
  double least = 1e300;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const path::Beside seen = path::beside(path[i], at);
    const double along = std::clamp(path::sense(path[i]) * seen.along, 0.0, path::size(path[i]));
    const Pose there = path::pose_at(path[i], path::sense(path[i]) * along);
    const double away = std::hypot(at.x - there.x, at.y - there.y);
    const double cost = away + kPerRadian * std::abs(signed_angle(at.rho - there.rho));
    if (cost >= least) continue;
    least = cost;
    best = {i, along, std::copysign(away, seen.across)};
  }
  return best;
}

Pose ahead_of(std::span<const PolarSpline> path, const PathPosition& position, double distance) {
  std::size_t i = position.spline;
  double along = position.along + distance;
  while (along > path::size(path[i]) && i + 1 < path.size()) along -= path::size(path[i++]);
  along = std::min(along, path::size(path[i]));
  return path::pose_at(path[i], path::sense(path[i]) * along);
}

double remaining_length(std::span<const PolarSpline> path, const PathPosition& position) {
  double rest = path::size(path[position.spline]) - position.along;
  for (std::size_t i = position.spline + 1; i < path.size(); ++i) rest += path::size(path[i]);
  return rest;
}

}  // namespace rack::dora
