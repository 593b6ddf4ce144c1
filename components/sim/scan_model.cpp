#include "components/sim/scan_model.h"

#include <cmath>

#include "components/geometry/pose.h"

namespace rack::sim {
namespace {

i32 mm(double value) { return Millimetres<i32>::from_si(value / 1000); }

template <typename Scan>
void begin(const OdometryData& from, std::chrono::milliseconds duration,
           const ScanSettings& settings, Scan& scan) {
  scan.recordingTime = from.recordingTime;
  scan.duration = static_cast<u32>(duration.count());
  scan.maxRange = settings.max_range;
  scan.points.clear();
}

}  // namespace

ScanModel::ScanModel(FloorMap map, const ScanSettings& settings)
    : map_(std::move(map)),
      settings_(settings),
      ranges_(static_cast<std::size_t>(settings.count())) {}

void ScanModel::see(const OdometryData& from, std::chrono::milliseconds duration, LadarData& scan) {
  begin(from, duration, settings_, scan);
  scan.startAngle = static_cast<f32>(radians(settings_.first));
  scan.endAngle = static_cast<f32>(radians(settings_.last));
  cast(from);
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const i32 distance = mm(ranges_[i]);
    scan.points.push_back(
        {.angle = static_cast<f32>(angle(i)),
         .distance = distance,
         .type = distance >= settings_.max_range ? ladar_point::kInvalid : ladar_point::kUnknown});
  }
}

void ScanModel::see(const OdometryData& from, std::chrono::milliseconds duration,
                    Scan2dData& scan) {
  begin(from, duration, settings_, scan);
  cast(from);
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const double range = ranges_[i];
    const bool too_far = mm(range) >= settings_.max_range;
    scan.points.push_back({.x = mm(range * std::cos(angle(i))),
                           .y = mm(range * std::sin(angle(i))),
                           .z = mm(range),
                           .type = too_far ? scan_point::kMaxRange | scan_point::kInvalid : 0});
  }
}

void ScanModel::cast(const OdometryData& from) {
  const MapPoint at{static_cast<double>(from.pos.x), static_cast<double>(from.pos.y)};
  const double first = static_cast<double>(from.pos.rho) + radians(settings_.first);
  map_.cast({at, first, radians(settings_.step)}, settings_.max_range, ranges_);
}

double ScanModel::angle(std::size_t ray) const {
  return radians(settings_.first + settings_.step * static_cast<i32>(ray));
}

}  // namespace rack::sim
