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
  double behind;
  double left;
  double right;
};

Box box_of(Direction direction, const ChassisParamData& chassis) {
  const double margin = chassis.safetyMargin;
  const double way = margin + chassis.safetyMarginMove.raw();
  const double front = chassis.boundaryFront;
  const double back = chassis.boundaryBack;
  const double left = chassis.boundaryLeft;
  const double right = chassis.boundaryRight;
  switch (direction) {
    case Direction::kForward:
      break;
    case Direction::kBackward:
      return {back + way, front, right + margin, left + margin};
    case Direction::kLeft:
      return {left + way, right, back + margin, front + margin};
    case Direction::kRight:
      return {right + way, left, front + margin, back + margin};
  }
  return {front + way, back, left + margin, right + margin};
}

struct Seen {
  double ahead;
  double right;
};

Seen seen(const ScanPoint& point, Direction direction) {
  const double x = point.x;
  const double y = point.y;
  switch (direction) {
    case Direction::kForward:
      break;
    case Direction::kBackward:
      return {-x, -y};
    case Direction::kLeft:
      return {-y, x};
    case Direction::kRight:
      return {y, -x};
  }
  return {x, y};
}

double speed_for(const ScanPoint& point, Direction direction, const Box& box,
                 double break_constant) {
  const Seen at = seen(point, direction);
  if (at.ahead < -box.behind) return std::numeric_limits<double>::infinity();  // it goes away
  const double ahead = std::max(0.0, at.ahead - box.ahead);
  const double besides = std::max({0.0, at.right - box.right, -at.right - box.left});
  const bool moves = (point.type & scan_point::kClassMask) == kDynamicObstacle;
  return std::max(ahead, kBesides * besides) / (break_constant * (moves ? kMoving : 1));
}

i32 speed_max(Direction direction, const ChassisParamData& chassis) {
  if (direction == Direction::kForward) return chassis.vxMax;
  if (direction == Direction::kBackward) return std::min(chassis.vxMax.raw(), kBackwardMax);
  return chassis.vyMax;
}

}  // namespace

i32 safe_speed(Direction direction, const ChassisParamData& chassis, const Scan2dData& scan) {
  const Box box = box_of(direction, chassis);
  // A vehicle that brakes at once has none.
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

}  // namespace rack::pilot
