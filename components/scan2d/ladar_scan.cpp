#include "components/scan2d/ladar_scan.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>

#include "components/geometry/pose.h"
#include "components/geometry/scatter.h"

namespace rack::scan2d {
namespace {

i32 median(i32 a, i32 b, i32 c) { return std::max(std::min(a, b), std::min(std::max(a, b), c)); }

bool is_reflector(const LadarPoint& point) { return (point.type & ladar_point::kReflector) != 0; }

// Invalid points and reflectors are not filtered.
i32 distance_of(const LadarData& ladar, std::size_t i, bool filtered) {
  const auto& points = ladar.points;
  if (!filtered || i == 0 || i + 1 >= points.size()) return points[i].distance;
  const auto three = std::span(points).subspan(i - 1, 3);
  const bool all = std::ranges::all_of(
      three, [](const LadarPoint& p) { return !is_reflector(p) && p.distance > 0; });
  return all ? median(three[0].distance, three[1].distance, three[2].distance)
             : three[1].distance.raw();
}

i32 type_of(const LadarPoint& point) {
  if (is_reflector(point)) return scan_point::kReflector;
  return point.type == ladar_point::kUnknown ? 0 : scan_point::kInvalid;
}

// --- reflectors

constexpr double kNeighbours = 250;               // mm, range of points used for the line of a wall
constexpr double kAtRightAngles = radians(15.0);  // tolerance

bool shines(const Scan2dData& scan, std::size_t i) {
  return i < scan.points.size() && (scan.points[i].type & scan_point::kReflector) != 0;
}

bool is_one_of_three(const Scan2dData& scan, std::size_t i) {
  // for the first point, i - 1 is out of range, too
  return (shines(scan, i - 1) && shines(scan, i + 1)) ||
         (shines(scan, i - 1) && shines(scan, i - 2)) ||
         (shines(scan, i + 1) && shines(scan, i + 2));
}

bool is_near(const ScanPoint& a, const ScanPoint& b) {
  return std::hypot(static_cast<double>(a.x) - b.x, static_cast<double>(a.y) - b.y) <= kNeighbours;
}

// The points around one without a gap.
std::span<const ScanPoint> wall_around(const Scan2dData& scan, std::size_t i) {
  const auto& points = scan.points;
  std::size_t first = i;
  std::size_t last = i;
  while (first > 0 && is_near(points[first - 1], points[i])) --first;
  while (last + 1 < points.size() && is_near(points[last + 1], points[i])) ++last;
  return std::span(points).subspan(first, last - first + 1);
}

void drop_shining_walls(const LadarMounting& mounting, Scan2dData& scan) {
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    if (!shines(scan, i) || is_one_of_three(scan, i)) continue;
    const auto wall = wall_around(scan, i);
    if (wall.size() < 2) continue;
    ScanPoint& point = scan.points[i];
    Scatter scatter;
    for (const ScanPoint& one : wall) scatter.add(one.x - point.x, one.y - point.y);
    const double ray = std::atan2(static_cast<double>(point.y) - mounting.y,
                                  static_cast<double>(point.x) - mounting.x);
    if (std::abs(std::cos(ray - scatter.direction())) <= std::sin(kAtRightAngles))
      point.type &= ~scan_point::kReflector;
  }
}

// --- movement of the robot during a scan

constexpr double kLongestScan = 1000;  // ms
constexpr double kSpeed = 30;          // mm per ms
constexpr double kTurning = 0.0125;    // rad per ms: two turns per second

// Pose of the ladar at the i-th point, relative to the middle of the scan. Such a short movement is
// taken as straight.
Pose ladar_at(std::size_t i, std::size_t count, const LadarMounting& mounting, const Pose& motion) {
  const double after =
      count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) - 0.5 : 0;
  const double part = mounting.is_reversed ? -after : after;
  const Pose robot{
      .x = part * motion.x, .y = part * motion.y, .rho = part * signed_angle(motion.rho)};
  return robot + Pose{.x = static_cast<double>(mounting.x),
                      .y = static_cast<double>(mounting.y),
                      .rho = mounting.rho};
}

}  // namespace

Pose motion_during_scan(const Pose& before, const Pose& now, double ms_between, double ms_of_scan) {
  const Pose step = now - before;
  const double distance = std::hypot(step.x, step.y);
  const double turn = std::abs(signed_angle(step.rho));
  const bool is_plausible = ms_between > 0 && ms_of_scan > 0 && ms_of_scan <= kLongestScan &&
                            distance <= kSpeed * ms_between && turn <= kTurning * ms_between;
  if (!is_plausible) return {};  // also when it is not a number
  const double part = ms_of_scan / ms_between;
  return {.x = part * step.x, .y = part * step.y, .rho = part * signed_angle(step.rho)};
}

void convert(const LadarData& ladar, const LadarMounting& mounting, const ScanFilter& filter,
             Scan2dData& scan, const Pose& motion) {
  scan.recordingTime = ladar.recordingTime;
  scan.duration = ladar.duration;
  scan.maxRange = std::min(ladar.maxRange.raw(), filter.range_max);
  scan.points.clear();
  const auto step = static_cast<std::size_t>(std::max(filter.reduce, 1));
  for (std::size_t n = 0; n < ladar.points.size(); n += step) {
    const std::size_t i = mounting.upside_down ? ladar.points.size() - 1 - n : n;
    const LadarPoint& point = ladar.points[i];
    const double angle = mounting.upside_down ? -point.angle : point.angle.raw();
    // Also excludes angles that are not numbers.
    const bool is_seen = angle >= filter.angle_min && angle <= filter.angle_max;
    if (!is_seen) continue;
    i32 distance = distance_of(ladar, i, filter.median);
    i32 type = type_of(point);
    if (distance >= scan.maxRange || distance <= 0) {
      distance = scan.maxRange;
      type |= scan_point::kMaxRange | scan_point::kInvalid;
    }
    const Pose at = ladar_at(i, ladar.points.size(), mounting, motion);
    const double direction = angle + at.rho;
    scan.points.push_back(
        {.x = whole_millimetres(at.x + distance * std::cos(direction)),
         .y = whole_millimetres(at.y + distance * std::sin(direction)),
         .z = distance,
         .type = type,
         .intensity = static_cast<i16>(std::clamp(point.intensity, -32768, 32767))});
  }
  if (filter.reflectors) drop_shining_walls(mounting, scan);
}

tims::Result<void> add_intensities(const CameraData& camera, Scan2dData& scan) {
  const auto wrong = [](std::string text) {
    return tims::Error(tims::Errc::kInvalidArgument, std::move(text));
  };
  if (camera.recordingTime != scan.recordingTime)
    return wrong("the image has another time than the scan");
  const bool has_two_bytes =
      camera.mode == camera_mode::kMono12 || camera.mode == camera_mode::kMono16;
  if (!has_two_bytes || (camera.width != 1 && camera.height != 1))
    return wrong("the image has more than one row and column, or not 12 or 16 bits per pixel");
  if (camera.image.size() != 2 * scan.points.size())
    return wrong("the image has " + std::to_string(camera.image.size() / 2) + " pixels, the scan " +
                 std::to_string(scan.points.size()) + " points");
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const auto high = std::to_integer<u32>(camera.image[2 * i]);
    const auto low = std::to_integer<u32>(camera.image[2 * i + 1]);
    scan.points[i].intensity = static_cast<i16>(high << 8 | low);
  }
  return {};
}

}  // namespace rack::scan2d
