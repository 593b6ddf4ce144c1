// A vehicle that moves: speed commands in, movement out (specification, section 9.2).
#pragma once

#include "rack/proxies/geometry.h"
#include "rack/proxies/proxy.h"

namespace rack {

struct ChassisType {
  enum : i8 {
    kMove = 21,            // ChassisMoveData; ERROR when off or not from the active pilot
    kGetParameter = 22,    // answered by kParameter, also when off
    kSetActivePilot = 23,  // ChassisSetActivePilotData; the speed becomes 0
    kParameter = -21,      // ChassisParamData
  };
};

// Active pilot in ChassisData when there is none.
inline constexpr tims::Address kNoPilot{0xFFFFFF00};

struct ChassisData {
  TimeStamp recordingTime = 0;
  Millimetres<f32> deltaX = 0;  // movement since the previous data
  Millimetres<f32> deltaY = 0;
  Radians<f32> deltaRho = 0;
  MillimetresPerSecond<f32> vx = 0;
  MillimetresPerSecond<f32> vy = 0;
  RadiansPerSecond<f32> omega = 0;
  Quantity<f32, unit::Volt> battery = 0;
  tims::Address activePilot = kNoPilot;
};

struct ChassisMoveData {
  MillimetresPerSecond<i32> vx = 0;
  MillimetresPerSecond<i32> vy = 0;
  RadiansPerSecond<f32> omega = 0;
};

struct ChassisSetActivePilotData {
  tims::Address activePilot = {};  // its local id is ignored
};

struct ChassisParamData {
  MillimetresPerSecond<i32> vxMax = 0;
  MillimetresPerSecond<i32> vyMax = 0;
  MillimetresPerSecond<i32> vxMin = 0;  // smallest speed other than 0
  MillimetresPerSecond<i32> vyMin = 0;
  MillimetresPerSecond2<i32> accMax = 0;
  MillimetresPerSecond2<i32> decMax = 0;
  RadiansPerSecond<f32> omegaMax = 0;
  Millimetres<i32> minTurningRadius = 0;
  // distance needed to stop before an obstacle
  Quantity<f32, unit::MillimetrePerSpeed> breakConstant = 0;
  Millimetres<i32> safetyMargin = 0;  // around the hull
  // additional margin in the direction of movement
  Millimetres<i32> safetyMarginMove = 0;
  Millimetres<i32> comfortMargin = 0;
  Millimetres<i32> boundaryFront = 0;  // from the reference point to the hull
  Millimetres<i32> boundaryBack = 0;
  Millimetres<i32> boundaryLeft = 0;
  Millimetres<i32> boundaryRight = 0;
  Millimetres<i32> wheelBase = 0;
  Millimetres<i32> wheelRadius = 0;
  Millimetres<i32> trackWidth = 0;
  Quantity<f32, unit::RadianPerMillimetre> pilotParameterA =
      0;                                               // gain for the distance to the path
  Quantity<f32, unit::PerSecond> pilotParameterB = 0;  // gain for the heading
  MillimetresPerSecond<i32> pilotVTransMax = 0;
};

class ChassisProxy : public DataProxy<ChassisData, tims::class_id::kChassis> {
 public:
  using DataProxy::DataProxy;

  Result<void> move(MillimetresPerSecond<i32> vx, MillimetresPerSecond<i32> vy,
                    RadiansPerSecond<f32> omega) {
    return command(ChassisType::kMove, ChassisMoveData{vx, vy, omega});
  }
  // curve: 1/mm, positive to the right.
  Result<void> move_curve(MillimetresPerSecond<i32> speed,
                          Quantity<f32, unit::PerMillimetre> curve) {
    return move(speed, 0, curve * static_cast<f32>(speed));
  }
  // radius: 0 is straight ahead.
  Result<void> move_radius(MillimetresPerSecond<i32> speed, Millimetres<i32> radius) {
    const f32 omega = radius == 0 ? 0.0F : static_cast<f32>(speed) / static_cast<f32>(radius);
    return move(speed, 0, omega);
  }
  Result<ChassisParamData> get_parameter() {
    return query<ChassisParamData>(ChassisType::kGetParameter, ChassisType::kParameter);
  }
  Result<void> set_active_pilot(tims::Address pilot) {
    return command(ChassisType::kSetActivePilot, ChassisSetActivePilotData{pilot});
  }
};

}  // namespace rack
