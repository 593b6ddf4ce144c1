#include "components/pilot/joystick_drive.h"

#include <algorithm>
#include <cmath>

namespace rack::pilot {
namespace {

// -1 to 1.
double deflection(i32 percent, double exponent) {
  const double part = std::clamp(percent, -100, 100) / 100.0;
  if (exponent == 0) return part;
  const double bent = (std::exp2(exponent * std::abs(part)) - 1) / (std::exp2(exponent) - 1);
  return std::copysign(bent, part);
}

i32 limit_of(double speed, const JoystickData& stick, const JoystickDriveSettings& settings,
             const ChassisParamData& chassis, const Scan2dData* scan) {
  if (scan == nullptr || stick.buttons != 0) return settings.speed_max;
  const Direction direction = speed < 0 ? Direction::kBackward : Direction::kForward;
  return std::min(safe_speed(direction, chassis, *scan), settings.speed_max);
}

}  // namespace

Drive joystick_drive(const JoystickData& stick, const JoystickDriveSettings& settings,
                     const ChassisParamData& chassis, const Scan2dData* scan) {
  double speed = settings.speed_max * deflection(stick.position.x, settings.x_exponent);
  const double turn = deflection(stick.position.y, settings.y_exponent);
  const i32 safe = limit_of(speed, stick, settings, chassis, scan);
  const auto keep_to = [&speed](double limit) { speed = std::clamp(speed, -limit, limit); };
  keep_to(safe);
  double omega = turn * chassis.omegaMax;
  if (!settings.turns_at_rest) {
    const double curve = turn / std::max(settings.turning_radius_min, 1);
    keep_to(speed_for_curve(curve, chassis));
    omega = curve * speed;
  }
  const double side = settings.side_speed_max * deflection(stick.position.z, 0);
  return {.speed = static_cast<i32>(std::lround(speed)),
          .side = static_cast<i32>(std::lround(side)),
          .speed_max = safe,
          .omega = static_cast<f32>(omega)};
}

void describe(const Drive& drive, PilotData& data) {
  data.speed = drive.speed;
  data.curve = drive.speed == 0 ? 0 : drive.omega / static_cast<f32>(drive.speed);
  data.distanceToDest = -1;
  data.splines.resize(1);
  PolarSpline& way = data.splines[0];
  way = {};
  way.length = drive.speed;
  way.endPos.x = drive.speed;
  way.basepoint.x = drive.speed;
  way.basepoint.speed = std::abs(drive.speed);
  way.vMax = drive.speed_max;
  way.vStart = std::abs(drive.speed);
  way.vEnd = std::abs(drive.speed);
}

}  // namespace rack::pilot
