#include "components/path/detour.h"

#include <algorithm>
#include <cmath>

#include "components/path/path_maker.h"

namespace rack::path {

OnPath further(std::span<const PolarSpline> path, const OnPath& from, double distance) {
  OnPath at = from;
  at.distance += distance;
  while (at.index + 1 < path.size() && at.distance > size(path[at.index])) {
    at.distance -= size(path[at.index]);
    ++at.index;
  }
  at.distance = std::min(at.distance, size(path[at.index]));
  return at;
}

Pose pose_on(std::span<const PolarSpline> path, const OnPath& at) {
  const PolarSpline& spline = path[at.index];
  return pose_at(spline, sense(spline) * at.distance);
}

void append_rest(std::span<const PolarSpline> path, const OnPath& from,
                 std::vector<PolarSpline>& to) {
  const PolarSpline& cut = path[from.index];
  const double left = sense(cut) * (size(cut) - from.distance);
  if (std::abs(left) >= 1 && to.size() < kSplinesMax) {
    const Pose at = pose_on(path, from);
    const PolarSpline rest = cut.radius == 0 ? line(at, left) : arc(at, cut.radius, left);
    PolarSpline spline = cut;
    spline.startPos = rest.startPos;
    spline.centerPos = rest.centerPos;
    spline.length = rest.length;
    if (cut.radius == 0) spline.endPos = rest.endPos;
    to.push_back(spline);
  }
  const auto rest = path.subspan(from.index + 1);
  const std::size_t count = std::min(rest.size(), kSplinesMax - std::min(to.size(), kSplinesMax));
  to.insert(to.end(), rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(count));
}

void keep_to_corridor(FreeSpace& space, std::span<const PolarSpline> splines, const Place& near,
                      double distance) {
  for (std::size_t row = 0; row < space.rows(); ++row) {
    for (std::size_t column = 0; column < space.columns(); ++column) {
      const Place at = space.center_of(row, column);
      if (std::hypot(at.x - near.x, at.y - near.y) < distance) continue;
      const bool inside = std::any_of(splines.begin(), splines.end(), [&](const PolarSpline& s) {
        const Beside seen = beside(s, {.x = at.x, .y = at.y});
        const double along = sense(s) * seen.along;
        const double room = static_cast<double>(s.lbo);
        return std::abs(seen.across) <= room && along >= -room && along <= size(s) + room;
      });
      if (!inside) space.occupy(at);
    }
  }
  space.measure();
}

}  // namespace rack::path
