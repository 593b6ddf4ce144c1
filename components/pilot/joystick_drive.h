// What a stick wants a vehicle to do (specification, section 10.6). Pure.
//
// A stick is bent by an exponential curve, so that small deflections are finer than large ones.
// Forward and backward become a speed, no faster than what the scan allows (safe_speed.h), unless a
// button is held. Sideways becomes a curve (1/mm) where a vehicle steers, so that it stays on the
// same arc whatever its speed is; where it can turn at rest, a turning speed that is reduced with
// the speed.
#pragma once

#include "components/pilot/safe_speed.h"
#include "rack/proxies/joystick.h"
#include "rack/proxies/pilot.h"

namespace rack::pilot {

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
