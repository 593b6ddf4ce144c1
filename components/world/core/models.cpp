#include "components/world/core/models.h"

#include <algorithm>
#include <cmath>

#include "components/geometry/pose.h"

namespace rack::sim {

namespace {

float limited(float target, float smallest, float largest) {
  if (target == 0) return 0;
  return std::copysign(std::min(std::max(std::abs(target), smallest), largest), target);
}

template <typename Scan>
void begin(const OdometryData& from, std::chrono::milliseconds duration,
           const ScanSettings& settings, Scan& scan) {
  scan.recordingTime = from.recordingTime;
  scan.duration = static_cast<u32>(duration.count());
  scan.maxRange = settings.max_range;
  scan.points.clear();
}

}  // namespace

ChassisModel::ChassisModel(const ChassisParamData& limits, bool acceleration)
    : limits_(limits), acceleration_(acceleration) {}

void ChassisModel::set_active_pilot(tims::Address pilot) {
  pilot_ = pilot;
  wanted_ = {};
}

void ChassisModel::move(const ChassisMoveData& command) {
  const auto mm_per_s = [](i32 speed) { return static_cast<float>(speed); };
  wanted_.vx = limited(mm_per_s(command.vx), mm_per_s(limits_.vxMin), mm_per_s(limits_.vxMax));
  wanted_.vy = limited(mm_per_s(command.vy), mm_per_s(limits_.vyMin), mm_per_s(limits_.vyMax));
  const float omega = std::isfinite(command.omega.raw()) ? command.omega.raw() : 0;
  wanted_.omega = limited(omega, 0, limits_.omegaMax);
}

ChassisData ChassisModel::step(TimeStamp now, std::chrono::milliseconds period) {
  const float seconds = std::chrono::duration<float>(period).count();
  if (acceleration_) {
    now_.vx = approach(now_.vx, wanted_.vx, seconds);
    now_.vy = approach(now_.vy, wanted_.vy, seconds);
    now_.omega = wanted_.omega;
  } else {
    now_ = wanted_;
  }
  ChassisData data;
  data.recordingTime = now;
  data.deltaX = now_.vx * seconds;
  data.deltaY = now_.vy * seconds;
  data.deltaRho = now_.omega * seconds;
  data.vx = now_.vx;
  data.vy = now_.vy;
  data.omega = now_.omega;
  data.activePilot = pilot_;
  return data;
}

// Changes `from` towards `to`, with decMax when braking. An acceleration of 0 is no limit.
float ChassisModel::approach(float from, float to, float seconds) const {
  const bool braking = std::abs(to) < std::abs(from) || to * from < 0;
  const i32 rate = braking ? limits_.decMax : limits_.accMax;
  if (rate <= 0) return to;
  const float step = static_cast<float>(rate) * seconds;
  return from + std::clamp(to - from, -step, step);
}

ScanModel::ScanModel(FloorMap map, const ScanSettings& settings)
    : map_(std::move(map)),
      settings_(settings),
      ranges_(static_cast<std::size_t>(settings.count())) {}

void ScanModel::measure(const OdometryData& from, std::chrono::milliseconds duration,
                        LadarData& scan) {
  begin(from, duration, settings_, scan);
  scan.startAngle = static_cast<f32>(radians(settings_.first));
  scan.endAngle = static_cast<f32>(radians(settings_.last));
  cast(from);
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const i32 distance = whole_millimetres(ranges_[i]);
    scan.points.push_back(
        {.angle = static_cast<f32>(angle(i)),
         .distance = distance,
         .type = distance >= settings_.max_range ? ladar_point::kInvalid : ladar_point::kUnknown});
  }
}

void ScanModel::measure(const OdometryData& from, std::chrono::milliseconds duration,
                        Scan2dData& scan) {
  begin(from, duration, settings_, scan);
  cast(from);
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    const double range = ranges_[i];
    const bool too_far = whole_millimetres(range) >= settings_.max_range;
    scan.points.push_back({.x = whole_millimetres(range * std::cos(angle(i))),
                           .y = whole_millimetres(range * std::sin(angle(i))),
                           .z = whole_millimetres(range),
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
