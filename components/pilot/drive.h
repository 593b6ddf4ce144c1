// Driving a vehicle manually: the speed that a scan allows, and the meaning of the stick
// (specification, section 10.6). Pure.
#pragma once

#include "rack/proxies/chassis.h"
#include "rack/proxies/joystick.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/scan2d.h"

namespace rack::pilot {

// --- Maximum speed
//
// A box surrounds the vehicle: its hull plus the safety margin, which is larger in the direction of
// travel. Each point has a distance to this box, straight ahead or to the side; a lateral distance
// counts four times, since the vehicle may pass obstacles closer than it may approach them. The
// vehicle needs breakConstant millimetres of braking distance per mm/s, so the distance divided by
// this constant is the speed that the point allows; the minimum over all points is the result. A
// moving object may come closer in that time, and allows a third. Landmarks are not obstacles.

// Classes of a scan's points (the original's numbers).
inline constexpr i32 kLandmark = 1;
inline constexpr i32 kDynamicObstacle = 3;

inline constexpr double kLateral = 4;  // factor on the distance of points beside the vehicle
inline constexpr double kMoving = 3;   // divisor of the distance of moving objects

// Whether a point can be an obstacle: a valid measurement, not on a landmark.
inline bool counts(const ScanPoint& point) {
  return (point.type & scan_point::kInvalid) == 0 &&
         (point.type & scan_point::kClassMask) != kLandmark;
}

enum class Direction : std::uint8_t { kForward, kRight, kBackward, kLeft };  // clockwise

// The maximum speed, mm/s and not negative, from which the vehicle can still stop in time. Ignores
// landmarks, invalid points and those behind the hull; keeps three times the distance to moving
// objects.
i32 safe_speed(Direction direction, const ChassisParamData& chassis, const Scan2dData& scan);

// The maximum speed at which the vehicle can turn with that curvature, 1/mm.
double speed_for_curve(double curve, const ChassisParamData& chassis);

inline constexpr i32 kBackwardMax = 500;  // mm/s

// --- Meaning of the stick
//
// Deflections are mapped by an exponential curve, so that small ones are finer than large ones.
// Forward and backward are a speed, limited to what the scan allows unless a button is held.
// Sideways is a curvature (1/mm) for a vehicle that steers, so that it stays on the same arc at any
// speed; for a vehicle that turns at rest, it is an angular speed that decreases with the speed.

struct Drive {
  i32 speed = 0;       // mm/s
  i32 side = 0;        // mm/s, to the right
  i32 speed_safe = 0;  // mm/s, the limit of the scan and the curve; negative backward
  f32 omega = 0;       // rad/s
  i32 target = 0;      // mm/s, requested speed, before the limit
};

struct JoystickDriveSettings {
  i32 speed_max = 4000;          // mm/s
  i32 side_speed_max = 0;        // mm/s
  bool turns_at_rest = false;    // y is an angular speed; else a curvature
  i32 turning_radius_min = 300;  // mm
  double x_exponent = 0;         // 0: linear; larger: finer near the centre
  double y_exponent = 0;
};

// `scan`: nullptr: no limit by obstacles.
Drive joystick_drive(const JoystickData& stick, const JoystickDriveSettings& settings,
                     const ChassisParamData& chassis, const Scan2dData* scan);

// As the original's pilot publishes it: a straight line, as long as the stick requests for one
// second. Backward its length and its speeds are negative.
void describe(const Drive& drive, const ChassisParamData& chassis, PilotData& data);

}  // namespace rack::pilot
