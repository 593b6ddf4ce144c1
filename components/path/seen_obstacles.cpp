#include "components/path/seen_obstacles.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace rack::path {
namespace {

constexpr double kExplained = 150;  // mm: a point this near to a wall of the map is explained by it
constexpr double kBehindIt = 200;   // mm: farther than a mark, a beam has passed through it
constexpr i32 kLandmark = 1;
constexpr std::size_t kDirections = 720;

std::size_t direction_of(double x, double y) {
  return static_cast<std::size_t>(heading(std::atan2(y, x)) / (2 * kPi) * kDirections) %
         kDirections;
}

}  // namespace

SeenObstacles::SeenObstacles() {
  reserve_all(scan_);
  marks_.reserve(kMost);
}

void SeenObstacles::take(const Scan2dData& scan, const Pose& from) {
  scan_ = scan;
  from_ = from;
  seen_ = true;
}

void SeenObstacles::update(const FreeSpace& space, const FreeSpace* map) {
  if (!seen_) return;
  forget_what_has_gone();
  remember(space, map);
}

void SeenObstacles::forget_what_has_gone() {
  std::array<double, kDirections> seen{};
  for (const ScanPoint& point : scan_.points) {
    if ((point.type & scan_point::kInvalid) != 0) continue;
    double& nearest = seen.at(direction_of(point.x, point.y));
    const double range = std::hypot(point.x.raw(), point.y.raw());
    nearest = nearest == 0 ? range : std::min(nearest, range);
  }
  std::erase_if(marks_, [&](const Place& mark) {
    const Pose at = Pose{.x = mark.x, .y = mark.y} - from_;
    const std::size_t direction = direction_of(at.x, at.y);
    const double needed = std::hypot(at.x, at.y) + kBehindIt;
    bool any = false;
    for (const std::size_t beside : {kDirections - 1, std::size_t{0}, std::size_t{1}}) {
      const double range = seen.at((direction + beside) % kDirections);
      if (range != 0 && range < needed) return false;
      any = any || range != 0;
    }
    return any;
  });
}

void SeenObstacles::remember(const FreeSpace& space, const FreeSpace* map) {
  for (const ScanPoint& point : scan_.points) {
    if ((point.type & scan_point::kInvalid) != 0 ||
        (point.type & scan_point::kClassMask) == kLandmark || marks_.size() == kMost)
      continue;
    const Pose at = from_ + Pose{.x = 1.0 * point.x, .y = 1.0 * point.y};
    const Place place{at.x, at.y};
    if (!space.contains(place) || space.occupied(place)) continue;
    if (map != nullptr && map->clearance(place) < kExplained) continue;
    marks_.push_back(place);
  }
}

}  // namespace rack::path
