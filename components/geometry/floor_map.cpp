#include "components/geometry/floor_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "components/geometry/pose.h"

namespace rack {

namespace {

constexpr double kCorner = 1e-3;  // mm: no ray passes between joined walls
constexpr double kNearlyStraight = 1e-6;

}  // namespace

FloorMap::FloorMap(const DxfDrawing& drawing, double scale, double offset_x, double offset_y) {
  const auto point = [&](const DxfPoint& p) {
    return MapPoint{(p.y - offset_x) * scale, (p.x - offset_y) * scale};
  };
  for (const DxfLine& line : drawing.lines) {
    const MapPoint from = point(line.from);
    const MapPoint to = point(line.to);
    const MapPoint extent{to.x - from.x, to.y - from.y};
    walls_.push_back({from, extent, std::hypot(extent.x, extent.y)});
  }
}

void FloorMap::cast(const RayFan& fan, double max_range, std::span<double> ranges) const {
  std::ranges::fill(ranges, max_range);
  for (const Wall& wall : walls_) {
    if (wall.length > kCorner) cast(wall, fan, ranges);
  }
}

// Only the rays between the directions of the wall's ends are tested: the cost for all rays of a
// scan is little more than that of one ray against all walls.
void FloorMap::cast(const Wall& wall, const RayFan& fan, std::span<double> ranges) {
  const double x = wall.from.x - fan.from.x;
  const double y = wall.from.y - fan.from.y;
  const double begin = std::atan2(y, x);
  const double turn = signed_angle(std::atan2(y + wall.extent.y, x + wall.extent.x) - begin);
  double first = turn < 0 ? begin + turn : begin;
  double width = std::abs(turn);
  if (width > kPi - kNearlyStraight) {  // the point is on the wall: either side may be the front
    first = begin;
    width = 2 * kPi;
  }
  const double count = static_cast<double>(ranges.size());
  double from = heading(first - fan.first) - 2 * kPi;
  while (from <= fan.step * count) {  // a fan may contain a direction more than once
    const double low = std::clamp(std::floor(from / fan.step), 0.0, count);
    const double high = std::clamp(std::ceil((from + width) / fan.step) + 1, 0.0, count);
    for (auto i = static_cast<std::size_t>(low); i < static_cast<std::size_t>(high); ++i) {
      const double angle = fan.first + fan.step * static_cast<double>(i);
      ranges[i] = range(wall, fan.from, angle, ranges[i]);
    }
    from += 2 * kPi;
  }
}

double FloorMap::range(const Wall& wall, const MapPoint& from, double angle, double otherwise) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  const double x = wall.from.x - from.x;
  const double y = wall.from.y - from.y;
  const double across = c * wall.extent.y - s * wall.extent.x;
  if (std::abs(across) < kNearlyStraight * wall.length) return otherwise;  // along the wall
  const double range = (x * wall.extent.y - y * wall.extent.x) / across;
  const double part = (x * s - y * c) / across;  // of the wall
  const double tolerance = kCorner / wall.length;
  const bool hits = range >= 0 && part >= -tolerance && part <= 1 + tolerance;
  return hits ? std::min(range, otherwise) : otherwise;
}

double FloorMap::clearance(const MapPoint& at) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Wall& wall : walls_) {
    const double x = at.x - wall.from.x;
    const double y = at.y - wall.from.y;
    const double square = wall.length * wall.length;
    const double part =
        square == 0 ? 0 : std::clamp((x * wall.extent.x + y * wall.extent.y) / square, 0.0, 1.0);
    nearest = std::min(nearest, std::hypot(x - part * wall.extent.x, y - part * wall.extent.y));
  }
  return nearest;
}

}  // namespace rack
