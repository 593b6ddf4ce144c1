#include "components/pilot/drive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace rack::pilot {

namespace {

constexpr i64 kMost = std::numeric_limits<i32>::max();

// The box around the vehicle, relative to the direction of travel.
struct Box {
  double ahead;
  double right;
  double behind;
  double left;
};

// From four sides, clockwise from the front: the one `turns` quarter turns to the right of the
// direction.
template <typename Sides>
double side(const Sides& sides, Direction direction, std::size_t quarters) {
  return sides[(static_cast<std::size_t>(direction) + quarters) % 4];
}

Box box_of(Direction direction, const ChassisParamData& chassis) {
  const std::array<double, 4> hull = {
      static_cast<double>(chassis.boundaryFront), static_cast<double>(chassis.boundaryRight),
      static_cast<double>(chassis.boundaryBack), static_cast<double>(chassis.boundaryLeft)};
  const double margin = chassis.safetyMargin;
  const double front = margin + chassis.safetyMarginMove.raw();
  return {side(hull, direction, 0) + front, side(hull, direction, 1) + margin,
          side(hull, direction, 2), side(hull, direction, 3) + margin};
}

double speed_for(const ScanPoint& point, Direction direction, const Box& box,
                 double break_constant) {
  const double x = point.x;
  const double y = point.y;
  const std::array<double, 4> distances = {x, y, -x, -y};
  const double to_front = side(distances, direction, 0);
  const double to_right = side(distances, direction, 1);
  if (to_front < -box.behind)
    return std::numeric_limits<double>::infinity();  // the vehicle moves away from it
  const double ahead = std::max(0.0, to_front - box.ahead);
  const double lateral = std::max({0.0, to_right - box.right, -to_right - box.left});
  const bool moves = (point.type & scan_point::kClassMask) == kDynamicObstacle;
  return std::max(ahead, kLateral * lateral) / (break_constant * (moves ? kMoving : 1));
}

i32 speed_max(Direction direction, const ChassisParamData& chassis) {
  if (direction == Direction::kForward) return chassis.vxMax;
  if (direction == Direction::kBackward) return std::min(chassis.vxMax.raw(), kBackwardMax);
  return chassis.vyMax;
}

// -1 to 1.
double deflection(i32 percent, double exponent) {
  const double part = std::clamp(percent, -100, 100) / 100.0;
  if (exponent == 0) return part;
  const double bent = (std::exp2(exponent * std::abs(part)) - 1) / (std::exp2(exponent) - 1);
  return std::copysign(bent, part);
}

// Not negative. A pressed button overrides the limit.
i32 limit_of(Direction direction, i32 speed_max, const JoystickData& stick,
             const ChassisParamData& chassis, const Scan2dData* scan) {
  if (scan == nullptr || stick.buttons != 0) return speed_max;
  return std::min(safe_speed(direction, chassis, *scan), speed_max);
}

// The second number of MOVE, as the original sends it: what the scan and the curve allow, however
// fast the pilot may be; with a button pressed twice what the vehicle can; without a scan what it
// can, forward.
i32 limit_sent(Direction along, double curve, const JoystickData& stick,
               const ChassisParamData& chassis, const Scan2dData* scan) {
  const i32 fastest = std::max(chassis.vxMax.raw(), 0);
  if (scan == nullptr) return fastest;
  const i32 sign = along == Direction::kBackward ? -1 : 1;
  if (stick.buttons != 0) return static_cast<i32>(sign * std::min<i64>(2 * i64{fastest}, kMost));
  const double safe = safe_speed(along, chassis, *scan);
  return sign * static_cast<i32>(std::min(safe, speed_for_curve(curve, chassis)));
}

}  // namespace

i32 safe_speed(Direction direction, const ChassisParamData& chassis, const Scan2dData& scan) {
  const Box box = box_of(direction, chassis);
  // A vehicle that stops immediately has a break constant of 0.
  const double break_constant = std::max<double>(chassis.breakConstant, 1e-3);
  double speed = speed_max(direction, chassis);
  for (const ScanPoint& point : scan.points) {
    if (counts(point)) speed = std::min(speed, speed_for(point, direction, box, break_constant));
  }
  if (speed <= 0) return 0;
  const bool sideways = direction == Direction::kLeft || direction == Direction::kRight;
  const i32 smallest = sideways ? chassis.vyMin : chassis.vxMin;
  return std::max(static_cast<i32>(speed), smallest);
}

double speed_for_curve(double curve, const ChassisParamData& chassis) {
  if (curve == 0) return std::numeric_limits<double>::infinity();
  return static_cast<double>(chassis.omegaMax) / std::abs(curve);
}

Drive joystick_drive(const JoystickData& stick, const JoystickDriveSettings& settings,
                     const ChassisParamData& chassis, const Scan2dData* scan) {
  const double target = settings.speed_max * deflection(stick.position.x, settings.x_exponent);
  const Direction along = target < 0 ? Direction::kBackward : Direction::kForward;
  const i32 safe = limit_of(along, settings.speed_max, stick, chassis, scan);
  double speed = std::clamp(target, -1.0 * safe, 1.0 * safe);

  const double turn = deflection(stick.position.y, settings.y_exponent);
  double omega = turn * chassis.omegaMax;
  double curve = 0;
  if (!settings.turns_at_rest) {
    const i32 radius = std::max({settings.turning_radius_min, chassis.minTurningRadius.raw(), 1});
    curve = turn / radius;
    const double limit = speed_for_curve(curve, chassis);
    speed = std::clamp(speed, -limit, limit);
    omega = curve * speed;
  } else if (target != 0) {
    omega *= speed / target;  // braking keeps the curvature
  }

  const double aside = settings.side_speed_max * deflection(stick.position.z, 0);
  const Direction across = aside < 0 ? Direction::kLeft : Direction::kRight;
  const double side_safe = limit_of(across, settings.side_speed_max, stick, chassis, scan);
  return {.speed = static_cast<i32>(std::lround(speed)),
          .side = static_cast<i32>(std::lround(std::clamp(aside, -side_safe, side_safe))),
          .speed_safe = limit_sent(along, curve, stick, chassis, scan),
          .omega = static_cast<f32>(omega),
          .target = static_cast<i32>(std::lround(target))};
}

void describe(const Drive& drive, const ChassisParamData& chassis, PilotData& data) {
  data.speed = drive.speed;
  data.curve = drive.speed == 0 ? 0 : drive.omega / static_cast<f32>(drive.speed);
  data.distanceToDest = -1;
  data.splines.resize(1);
  PolarSpline& line = data.splines[0];
  line = {};
  line.length = drive.target;
  line.endPos.x = drive.target;
  line.vMax = drive.target;
  line.vStart = drive.target;
  line.vEnd = drive.target;
  line.accMax = chassis.accMax;
  line.decMax = chassis.decMax;
}

}  // namespace rack::pilot
