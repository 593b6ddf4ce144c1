// How a vehicle is driven: how fast it may go among what a scan sees, and what a stick wants it to
// do (specification, section 10.6). Pure.
#pragma once

#include "rack/proxies/chassis.h"
#include "rack/proxies/joystick.h"
#include "rack/proxies/pilot.h"
#include "rack/proxies/scan2d.h"

namespace rack::pilot {

// --- How fast it may go
//
// Around the vehicle lies a box: its hull, the safety margin, and more of it in the direction of
// travel. From each point to this box there is a way, straight ahead or to the side; to the side it
// counts four times, since what is passed by may be nearer than what is headed for. The vehicle
// needs breakConstant millimetres of way for each mm/s to come to rest, so that the way divided by
// this constant is the speed that this point allows; the least of all points is the answer. What
// moves by itself may come closer meanwhile, and allows a third. Landmarks are passed through.

// Classes of a scan's points (the original's numbers).
inline constexpr i32 kLandmark = 1;
inline constexpr i32 kDynamicObstacle = 3;

inline constexpr double kBesides = 4;  // what the vehicle passes by may be that much nearer
inline constexpr double kMoving = 3;   // what moves by itself counts as that much nearer

// Whether a point can be an obstacle: a measurement, and not of a landmark.
inline bool counts(const ScanPoint& point) {
  return (point.type & scan_point::kInvalid) == 0 &&
         (point.type & scan_point::kClassMask) != kLandmark;
}

enum class Direction : std::uint8_t { kForward, kRight, kBackward, kLeft };  // clockwise

// The largest speed, mm/s and not negative, with which it still stops in time. Landmarks, points
// that are no measurement and those behind the hull do not count; what moves keeps it three times
// as far away.
i32 safe_speed(Direction direction, const ChassisParamData& chassis, const Scan2dData& scan);

// The largest at which it can still turn with that curvature, 1/mm.
double speed_for_curve(double curve, const ChassisParamData& chassis);

inline constexpr i32 kBackwardMax = 500;  // mm/s

// --- What a stick means
//
// A stick is bent by an exponential curve, so that small deflections are finer than large ones.
// Forward and backward become a speed, no faster than what the scan allows, unless a
// button is held. Sideways becomes a curve (1/mm) where a vehicle steers, so that it stays on the
// same arc whatever its speed is; where it can turn at rest, a turning speed that is reduced with
// the speed.

struct Drive {
  i32 speed = 0;       // mm/s
  i32 side = 0;        // mm/s, to the right
  i32 speed_safe = 0;  // mm/s, the largest that would be; negative backward
  f32 omega = 0;       // rad/s
  i32 wish = 0;        // mm/s, of whoever drives, before the speed was limited
};

struct JoystickDriveSettings {
  i32 speed_max = 4000;          // mm/s
  i32 side_speed_max = 0;        // mm/s
  bool turns_at_rest = false;    // y is a turning speed; else it is a curve
  i32 turning_radius_min = 300;  // mm
  double x_exponent = 0;         // 0: as far as the stick; more: finer near the middle
  double y_exponent = 0;
};

// `scan`: none: nothing looks where it goes.
Drive joystick_drive(const JoystickData& stick, const JoystickDriveSettings& settings,
                     const ChassisParamData& chassis, const Scan2dData* scan);

// As pilots publish it: as far as the stick wishes to go in a second, on a straight line.
void describe(const Drive& drive, PilotData& data);

}  // namespace rack::pilot
