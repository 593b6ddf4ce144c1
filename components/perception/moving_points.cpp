#include "components/perception/moving_points.h"

#include <cmath>

#include "components/geometry/pose.h"

namespace rack::perception {
namespace {

constexpr double kBesideMax = 1;  // s

bool is_pose(const Pose& pose) { return std::isfinite(pose.x + pose.y + pose.rho); }

// Uses the reference positions if both messages have one.
Pose objects_in_scan(const Pose& then, const Pose& now) {
  const Pose zero = Pose::of(Position3d{});
  const auto is_zero = [&](const Pose& p) {
    return p.x == zero.x && p.y == zero.y && p.rho == zero.rho;
  };
  return is_zero(then) || is_zero(now) ? zero : then - now;
}

}  // namespace

std::size_t mark_moving(const ObjRecogData& objects, const MovingPoints& settings,
                        Scan2dData& scan) {
  const double later =
      std::chrono::duration<double>(scan.recordingTime - objects.recordingTime).count();
  const Pose then = Pose::of(objects.refPos);
  const Pose now = Pose::of(scan.refPos);
  if (std::abs(later) > kBesideMax || !is_pose(then) || !is_pose(now)) return 0;
  const Pose frame = objects_in_scan(then, now);
  std::size_t marked = 0;
  for (const ObjRecogObject& object : objects.objects) {
    const double vx = object.vel.x;
    const double vy = object.vel.y;
    if (std::hypot(vx, vy) < settings.speed_min) continue;
    Pose box = Pose::of(object.pos);
    if (!is_pose(box)) continue;
    box.x += vx * later;
    box.y += vy * later;
    box = frame + box;
    const double c = std::cos(box.rho);
    const double s = std::sin(box.rho);
    for (ScanPoint& point : scan.points) {
      if ((point.type & scan_point::kInvalid) != 0) continue;
      const double dx = point.x - box.x;
      const double dy = point.y - box.y;
      const bool inside = std::abs(dx * c + dy * s) <= object.dim.x / 2.0 + settings.margin &&
                          std::abs(dy * c - dx * s) <= object.dim.y / 2.0 + settings.margin;
      if (!inside || (point.type & scan_point::kClassMask) == kDynamicObstacle) continue;
      point.type |= kDynamicObstacle;
      ++marked;
    }
  }
  return marked;
}

}  // namespace rack::perception
