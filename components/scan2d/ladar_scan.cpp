#include "components/scan2d/ladar_scan.h"

#include <algorithm>
#include <cmath>

namespace rack::scan2d {
namespace {

i32 mm(double value) { return Millimetres<i32>::from_si(value / 1000); }

i32 median(i32 a, i32 b, i32 c) { return std::max(std::min(a, b), std::min(std::max(a, b), c)); }

i32 distance_of(const LadarData& ladar, std::size_t i, bool filtered) {
  const auto& points = ladar.points;
  if (!filtered || i == 0 || i + 1 >= points.size()) return points[i].distance;
  return median(points[i - 1].distance, points[i].distance, points[i + 1].distance);
}

bool is_reflector(const LadarData& ladar, std::size_t i) {
  return i < ladar.points.size() && (ladar.points[i].type & ladar_point::kReflector) != 0;
}

i32 type_of(const LadarData& ladar, std::size_t i, const ScanFilter& filter) {
  const i32 type = ladar.points[i].type;
  if ((type & ladar_point::kReflector) != 0) {
    // i - 1 of the first point is no point either
    const bool alone = !is_reflector(ladar, i - 1) && !is_reflector(ladar, i + 1);
    return filter.reflectors && alone ? 0 : scan_point::kReflector;
  }
  return type == ladar_point::kUnknown ? 0 : scan_point::kInvalid;
}

}  // namespace

void convert(const LadarData& ladar, const LadarMounting& mounting, const ScanFilter& filter,
             Scan2dData& scan) {
  scan.recordingTime = ladar.recordingTime;
  scan.duration = ladar.duration;
  scan.maxRange = std::min(ladar.maxRange.raw(), filter.range_max);
  scan.points.clear();
  const auto step = static_cast<std::size_t>(std::max(filter.reduce, 1));
  for (std::size_t i = 0; i < ladar.points.size(); i += step) {
    const double angle = ladar.points[i].angle;
    // Also leaves out angles that are no number.
    if (!(angle >= filter.angle_min && angle <= filter.angle_max)) continue;
    i32 distance = distance_of(ladar, i, filter.median);
    i32 type = type_of(ladar, i, filter);
    if (distance >= scan.maxRange || distance <= 0) {
      distance = scan.maxRange;
      type |= scan_point::kMaxRange | scan_point::kInvalid;
    }
    const double direction = (mounting.upside_down ? -angle : angle) + mounting.rho;
    scan.points.push_back(
        {.x = mm(mounting.x + distance * std::cos(direction)),
         .y = mm(mounting.y + distance * std::sin(direction)),
         .z = distance,
         .type = type,
         .intensity = static_cast<i16>(std::clamp(ladar.points[i].intensity, -32768, 32767))});
  }
}

}  // namespace rack::scan2d
