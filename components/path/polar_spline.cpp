#include "components/path/polar_spline.h"

#include <algorithm>
#include <cmath>

namespace rack::path {

namespace {

constexpr double kCorner = 0.004;    // rad; smaller angles are rounding errors
constexpr double kLineOfEnds = 1e6;  // mm; shorter lines use their stored heading
constexpr double kRightAngle = kPi / 2;

Position2d rounded(const Pose& pose) {
  const Position3d position = pose.position();
  return {position.x, position.y, position.rho};
}

// A 32-bit heading is exact to a millimetre in 3 km; for longer lines the end points are more
// exact.
double heading_of_line(const PolarSpline& spline) {
  if (size(spline) < kLineOfEnds) return spline.startPos.rho;
  const double x = sense(spline) * (1.0 * spline.endPos.x - 1.0 * spline.startPos.x);
  const double y = sense(spline) * (1.0 * spline.endPos.y - 1.0 * spline.startPos.y);
  return x == 0 && y == 0 ? static_cast<double>(spline.startPos.rho) : std::atan2(y, x);
}

Pose moved(const Pose& from, double along, double across) {
  const double s = std::sin(from.rho);
  const double c = std::cos(from.rho);
  return {
      .x = from.x + along * c - across * s, .y = from.y + along * s + across * c, .rho = from.rho};
}

PolarSpline between_poses(const Pose& from, const Pose& to, const Pose& center, double length) {
  PolarSpline spline;
  spline.startPos = rounded(from);
  spline.endPos = rounded(to);
  spline.centerPos = rounded(center);
  spline.length = whole_millimetres(length);
  return spline;
}

}  // namespace

PolarSpline line(const Pose& from, double length) {
  return between_poses(from, moved(from, length, 0), from, length);
}

PolarSpline arc(const Pose& from, i32 radius, double length) {
  Pose center = moved(from, 0, radius);
  const double side = radius < 0 ? -1 : 1;
  Pose to = center;
  to.rho = from.rho + length / radius;
  to = moved(to, 0, -radius);
  center.rho = from.rho - side * kRightAngle;
  PolarSpline spline = between_poses(from, to, center, length);
  spline.radius = radius;
  return spline;
}

Pose pose_at(const PolarSpline& spline, double along) {
  Pose start = Pose::of(spline.startPos);
  if (spline.radius == 0) {
    start.rho = heading_of_line(spline);
    return moved(start, along, 0);
  }
  Pose at = Pose::of(spline.centerPos);
  at.rho = start.rho + along / spline.radius;
  return moved(at, 0, -1.0 * spline.radius);
}

Beside beside(const PolarSpline& spline, const Pose& at) {
  if (spline.radius == 0) {
    Pose start = Pose::of(spline.startPos);
    start.rho = heading_of_line(spline);
    const Pose seen = at - start;
    return {seen.x, seen.y, signed_angle(at.rho - start.rho)};
  }
  const Pose center = Pose::of(spline.centerPos);
  const double radius = spline.radius;
  const double side = radius < 0 ? -1 : 1;
  const double bearing = std::atan2(at.y - center.y, at.x - center.x);
  // In the sense of travel, so that points ahead are positive.
  const double ahead =
      side * sense(spline) * (bearing - (spline.startPos.rho - side * kRightAngle));
  const double opening = size(spline) / std::abs(radius);
  // The angle is wrapped opposite to the arc.
  const double before = std::max(0.0, std::min(kPi, (2 * kPi - opening) / 2));
  const double angle = heading(ahead + before) - before;
  const double along = sense(spline) * angle * std::abs(radius);
  const double distance = std::hypot(at.x - center.x, at.y - center.y);
  return {along, side * (std::abs(radius) - distance),
          signed_angle(at.rho - spline.startPos.rho - along / radius)};
}

bool runs_on(const PolarSpline& from, const PolarSpline& to) {
  if (sense(from) != sense(to)) return false;
  const double turn = static_cast<double>(to.startPos.rho) - static_cast<double>(from.endPos.rho);
  return std::abs(signed_angle(turn)) < kCorner;
}

double speed_at(const PolarSpline& spline, double distance) {
  const double done = std::clamp(distance, 0.0, size(spline));
  const double start = spline.vStart;
  const double end = spline.vEnd;
  const double grown = std::sqrt(start * start + 2.0 * spline.accMax * done);
  const double left = std::sqrt(end * end + 2.0 * spline.decMax * (size(spline) - done));
  return std::min({static_cast<double>(spline.vMax), grown, left});
}

}  // namespace rack::path
