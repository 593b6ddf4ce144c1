// The properties of a chassis that paths depend on. Pure.
#pragma once

#include <algorithm>

#include "components/path/goal_planner.h"
#include "rack/proxies/chassis.h"

namespace rack::path {

// A differential drive: the minimum radius that such a chassis reports is within its own hull.
inline bool turns_at_rest(const ChassisParamData& chassis) {
  return chassis.minTurningRadius <=
         std::max(chassis.boundaryFront.raw(), chassis.boundaryBack.raw());
}

inline double half_width(const ChassisParamData& chassis) {
  return std::max(chassis.boundaryLeft.raw(), chassis.boundaryRight.raw());
}

inline HullDiscs::Size hull_of(const ChassisParamData& chassis) {
  return {.front = static_cast<double>(chassis.boundaryFront),
          .back = static_cast<double>(chassis.boundaryBack),
          .half_width = half_width(chassis),
          .margin = static_cast<double>(chassis.safetyMargin)};
}

// A path keeps a reserve to the limits of the chassis, so that the follower can correct errors.
inline PathLimits limits_of(const ChassisParamData& chassis) {
  constexpr double kOfAcceleration = 0.7;
  constexpr double kOfTurning = 0.9;
  constexpr double kBackwardMax = 500;  // mm/s
  PathLimits limits;
  limits.speed_max = chassis.vxMax;
  limits.backward_max = std::min(limits.speed_max, kBackwardMax);
  limits.acceleration = kOfAcceleration * chassis.accMax;
  limits.deceleration = kOfAcceleration * chassis.decMax;
  limits.omega_max = kOfTurning * chassis.omegaMax;
  limits.radius_min = turns_at_rest(chassis) ? 0 : static_cast<double>(chassis.minTurningRadius);
  limits.half_width = half_width(chassis);
  return limits;
}

}  // namespace rack::path
