// For tests: a robot drives through a hall, with a ladar on an axis that tilts or turns. The
// measurements of the ladar are computed point by point, each at its own time.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "components/scan3d/sweep.h"

namespace rack::scan3d {

struct Plane {
  Place normal{};   // unit vector to the outside
  double away = 0;  // mm from the origin of the world

  [[nodiscard]] double beyond(const Place& place) const {
    return normal.x * place.x + normal.y * place.y + normal.z * place.z - away;
  }
};

// 8 m wide, 3 m high, one corner of it cut off; the robot's origin is 0.6 m above the floor.
inline std::vector<Plane> hall(double ahead = 10000) {
  const double slope = radians(40);
  return {{{1, 0, 0}, ahead},
          {{-1, 0, 0}, 10000},
          {{0, 1, 0}, 4000},
          {{0, -1, 0}, 4000},
          {{0, 0, 1}, 600},
          {{0, 0, -1}, 2400},
          {{std::cos(slope), std::sin(slope), 0}, std::cos(slope) * ahead + 1340}};
}

struct Ride {
  SweepMounting mounting{};
  std::function<Pose(double s)> robot = [](double) { return Pose{}; };
  std::function<double(double s)> axis = [](double) { return 0.0; };
  int points = 181;
  double first = -kPi / 2;  // rad, of the ladar
  double last = kPi / 2;
  double period = 1 / 75.0;   // s
  double duration = 6.67e-3;  // s, of a flat scan
  double noise = 0;           // mm, of a range
  double axis_late = 0.06;    // s, delay of a sample
  double axis_period = 0.05;
  double pose_late = 0.04;
  double pose_period = 0.05;
  i32 range_max = 30000;  // mm
  std::mt19937 random{1};
};

// A ray: origin and direction.
struct Ray {
  Place from{};
  Place along{};
};

inline Ray ray(const Ride& ride, const Frame& robot, double axis, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle) * (ride.mounting.upside_down ? -1 : 1);
  Frame turned = Frame::about_z(axis);
  Place along{c, s, 0};
  switch (ride.mounting.mode) {
    case scan_mode::kRoll:
      turned = Frame::about_x(axis);
      break;
    case scan_mode::kPitch:
      turned = Frame::about_y(axis);
      break;
    case scan_mode::kYaw:
      along = {c, 0, s};
      break;
    case scan_mode::kTop:
      along = {s, 0, -c};
      break;
    default:
      along = {-s, 0, c};
  }
  const Frame ladar = robot * Frame(ride.mounting.axis) * turned;
  const Place from = ladar * ride.mounting.ladar;
  return {from, ladar * (ride.mounting.ladar + along) + from * -1};
}

// mm until the nearest wall.
inline double range(const std::vector<Plane>& walls, const Ray& ray) {
  double nearest = std::numeric_limits<double>::max();
  for (const Plane& wall : walls) {
    const Place& n = wall.normal;
    const double closer = n.x * ray.along.x + n.y * ray.along.y + n.z * ray.along.z;
    if (closer > 1e-9) nearest = std::min(nearest, -wall.beyond(ray.from) / closer);
  }
  return nearest;
}

inline constexpr u32 kEpoch = 4294967000U;  // the clock wraps during the drive
inline TimeStamp stamp(double s) { return kEpoch + static_cast<u32>(std::llround(s * 1000)); }

inline LadarData flat_scan(Ride& ride, const std::vector<Plane>& walls, double middle) {
  LadarData scan{.recordingTime = stamp(middle),
                 .duration = static_cast<u32>(std::llround(ride.duration * 1000)),
                 .maxRange = ride.range_max};
  std::normal_distribution<double> noise(0, 1);
  for (int i = 0; i < ride.points; ++i) {
    const double part = static_cast<double>(i) / (ride.points - 1);
    const double when = ride.mounting.is_reversed ? 0.5 - part : part - 0.5;
    const double s = middle + ride.duration * when;
    const double angle = ride.first + (ride.last - ride.first) * part;
    const double seen = range(walls, ray(ride, Frame(ride.robot(s)), ride.axis(s), angle));
    scan.points.push_back({.angle = static_cast<f32>(angle),
                           .distance = static_cast<i32>(std::lround(
                               std::min(seen, 1e6) + ride.noise * noise(ride.random)))});
  }
  return scan;
}

// Simulates from 0 to `end`, s: samples arrive with their delays. All messages are appended to
// `got`.
inline void drive(Ride& ride, const std::vector<Plane>& walls, double end, Sweep& sweep,
                  const std::function<void(const Scan3dData&)>& got) {
  Scan3dData message;
  double next_axis = 0.003;
  double next_pose = 0.011;
  for (double middle = 0.02; middle < end; middle += ride.period) {
    const double now = middle + ride.duration;  // the line's time, and the driver's
    for (; next_axis + ride.axis_late <= now; next_axis += ride.axis_period)
      sweep.add_axis(stamp(next_axis), static_cast<f32>(ride.axis(next_axis)));
    for (; next_pose + ride.pose_late <= now; next_pose += ride.pose_period)
      sweep.add_pose(stamp(next_pose), ride.robot(next_pose).position());
    sweep.add(flat_scan(ride, walls, middle));
    while (sweep.next(message)) got(message);
  }
}

// --- flatness of walls

struct Flatness {
  double p95 = 0;  // mm from the best fitting plane
  double max = 0;
  std::size_t points = 0;
};

inline Place in_world(const Scan3dData& scan, const ScanPoint& point) {
  return Frame(Pose::of(scan.refPos)) * Place{static_cast<double>(point.x.raw()),
                                              static_cast<double>(point.y.raw()),
                                              static_cast<double>(point.z.raw())};
}

// For the points near this wall, and not near another one. The best fitting plane differs from the
// wall by two small slopes: least squares over the two directions along it.
inline Flatness flatness(const Scan3dData& scan, const std::vector<Plane>& walls,
                         std::size_t wall) {
  struct Row {
    double u, v, off;
  };
  const Place& n = walls[wall].normal;
  const Place along = std::abs(n.z) > 0.5 ? Place{1, 0, 0} : Place{-n.y, n.x, 0};
  const Place up = std::abs(n.z) > 0.5 ? Place{0, 1, 0} : Place{0, 0, 1};
  std::vector<Row> rows;
  for (const ScanPoint& point : scan.points) {
    if ((point.type & scan_point::kInvalid) != 0) continue;
    const Place place = in_world(scan, point);
    bool is_its = std::abs(walls[wall].beyond(place)) < 150;
    for (std::size_t i = 0; i < walls.size(); ++i)
      is_its = is_its && (i == wall || walls[i].beyond(place) < -300);
    const auto dot = [&](const Place& a) { return a.x * place.x + a.y * place.y + a.z * place.z; };
    if (is_its) rows.push_back({dot(along) / 1000, dot(up) / 1000, walls[wall].beyond(place)});
  }
  if (rows.size() < 50) return {};
  const auto count = static_cast<double>(rows.size());
  Row mean{};
  for (const Row& row : rows) {
    mean.u += row.u / count;
    mean.v += row.v / count;
    mean.off += row.off / count;
  }
  double uu = 0, uv = 0, vv = 0, uo = 0, vo = 0;
  for (Row& row : rows) {
    row = {row.u - mean.u, row.v - mean.v, row.off - mean.off};
    uu += row.u * row.u;
    uv += row.u * row.v;
    vv += row.v * row.v;
    uo += row.u * row.off;
    vo += row.v * row.off;
  }
  const double determinant = uu * vv - uv * uv;
  const double a = determinant > 1e-6 ? (uo * vv - vo * uv) / determinant : 0;
  const double b = determinant > 1e-6 ? (vo * uu - uo * uv) / determinant : 0;
  std::vector<double> beside;
  beside.reserve(rows.size());
  for (const Row& row : rows) beside.push_back(std::abs(row.off - a * row.u - b * row.v));
  std::ranges::sort(beside);
  return {beside[beside.size() * 95 / 100], beside.back(), beside.size()};
}

}  // namespace rack::scan3d
