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

// Not negative. Who holds a button knows better.
i32 limit_of(Direction direction, i32 speed_max, const JoystickData& stick,
             const ChassisParamData& chassis, const Scan2dData* scan) {
  if (scan == nullptr || stick.buttons != 0) return speed_max;
  return std::min(safe_speed(direction, chassis, *scan), speed_max);
}

}  // namespace

Drive joystick_drive(const JoystickData& stick, const JoystickDriveSettings& settings,
                     const ChassisParamData& chassis, const Scan2dData* scan) {
  const double wish = settings.speed_max * deflection(stick.position.x, settings.x_exponent);
  const Direction along = wish < 0 ? Direction::kBackward : Direction::kForward;
  const i32 safe = limit_of(along, settings.speed_max, stick, chassis, scan);
  double speed = std::clamp(wish, -1.0 * safe, 1.0 * safe);

  const double turn = deflection(stick.position.y, settings.y_exponent);
  double omega = turn * chassis.omegaMax;
  if (!settings.turns_at_rest) {
    const i32 radius = std::max({settings.turning_radius_min, chassis.minTurningRadius.raw(), 1});
    const double curve = turn / radius;
    const double limit = speed_for_curve(curve, chassis);
    speed = std::clamp(speed, -limit, limit);
    omega = curve * speed;
  } else if (wish != 0) {
    omega *= speed / wish;  // the curve stays what it was when it brakes
  }

  const double aside = settings.side_speed_max * deflection(stick.position.z, 0);
  const Direction across = aside < 0 ? Direction::kLeft : Direction::kRight;
  const double side_safe = limit_of(across, settings.side_speed_max, stick, chassis, scan);
  return {.speed = static_cast<i32>(std::lround(speed)),
          .side = static_cast<i32>(std::lround(std::clamp(aside, -side_safe, side_safe))),
          .speed_safe = wish < 0 ? -safe : safe,
          .omega = static_cast<f32>(omega),
          .wish = static_cast<i32>(std::lround(wish))};
}

void describe(const Drive& drive, PilotData& data) {
  data.speed = drive.speed;
  data.curve = drive.speed == 0 ? 0 : drive.omega / static_cast<f32>(drive.speed);
  data.distanceToDest = -1;
  data.splines.resize(1);
  PolarSpline& way = data.splines[0];
  way = {};
  way.length = drive.wish;
  way.endPos.x = drive.wish;
  way.basepoint.x = drive.wish;
  way.basepoint.speed = std::abs(drive.wish);
  way.vMax = std::abs(drive.wish);
  way.vStart = std::abs(drive.wish);
  way.vEnd = std::abs(drive.wish);
}

}  // namespace rack::pilot
