#include "components/pilot/safe_speed.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rack::pilot {
namespace {

constexpr i32 kLandmark = 1;
constexpr i32 kDynamicObstacle = 3;
constexpr double kBesides = 4;  // what it passes by may be so much nearer than what it heads for
constexpr double kMoving = 3;

bool counts(const ScanPoint& point) {
  return (point.type & scan_point::kInvalid) == 0 &&
         (point.type & scan_point::kClassMask) != kLandmark;
}

// What the vehicle needs for itself, seen in the direction it goes.
struct Box {
  double ahead;
  double left;
  double right;
  double sign;  // of x ahead
};

Box box_of(Direction direction, const ChassisParamData& chassis) {
  const bool forward = direction == Direction::kForward;
  const i32 hull = forward ? chassis.boundaryFront : chassis.boundaryBack;
  const double margin = chassis.safetyMargin;
  return {.ahead = hull + margin + chassis.safetyMarginMove,
          .left = chassis.boundaryLeft + margin,
          .right = chassis.boundaryRight + margin,
          .sign = forward ? 1.0 : -1.0};
}

double speed_for(const ScanPoint& point, const Box& box, double break_constant) {
  const double x = box.sign * point.x;
  if (x < 0) return std::numeric_limits<double>::infinity();  // it goes away from this
  const double y = point.y;
  const double ahead = std::max(0.0, x - box.ahead);
  const double besides = std::max({0.0, y - box.right, -y - box.left});
  const bool moves = (point.type & scan_point::kClassMask) == kDynamicObstacle;
  return std::max(ahead, kBesides * besides) / (break_constant * (moves ? kMoving : 1));
}

}  // namespace

i32 safe_speed(Direction direction, const ChassisParamData& chassis, const Scan2dData& scan) {
  const Box box = box_of(direction, chassis);
  // A vehicle that brakes at once has none.
  const double break_constant = std::max<double>(chassis.breakConstant, 1e-3);
  double speed = direction == Direction::kForward ? chassis.vxMax.raw()
                                                  : std::min(chassis.vxMax.raw(), kBackwardMax);
  for (const ScanPoint& point : scan.points) {
    if (counts(point)) speed = std::min(speed, speed_for(point, box, break_constant));
  }
  if (speed <= 0) return 0;
  return std::max(static_cast<i32>(speed), chassis.vxMin.raw());
}

double speed_for_curve(double curve, const ChassisParamData& chassis) {
  if (curve == 0) return std::numeric_limits<double>::infinity();
  return static_cast<double>(chassis.omegaMax) / std::abs(curve);
}

}  // namespace rack::pilot
