// How fast a vehicle may go among what a scan sees (specification, section 10.6). Pure.
//
// Around the vehicle lies a box: its hull, the safety margin, and more of it in the direction of
// travel. From each point to this box there is a way, straight ahead or to the side; to the side it
// counts four times, since what is passed by may be nearer than what is headed for. The vehicle
// needs breakConstant millimetres of way for each mm/s to come to rest, so that the way divided by
// this constant is the speed that this point allows; the least of all points is the answer. What
// moves by itself may come closer meanwhile, and allows a third. Landmarks are passed through.
#pragma once

#include "rack/proxies/chassis.h"
#include "rack/proxies/scan2d.h"

namespace rack::pilot {

enum class Direction : std::uint8_t { kForward, kBackward, kLeft, kRight };

// The largest speed, mm/s and not negative, with which it still stops in time. Landmarks, points
// that are no measurement and those behind the hull do not count; what moves keeps it three times
// as far away.
i32 safe_speed(Direction direction, const ChassisParamData& chassis, const Scan2dData& scan);

// The largest at which it can still turn with that curvature, 1/mm.
double speed_for_curve(double curve, const ChassisParamData& chassis);

inline constexpr i32 kBackwardMax = 500;  // mm/s

}  // namespace rack::pilot
