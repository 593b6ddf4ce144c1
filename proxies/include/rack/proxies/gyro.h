// An inertial measurement unit (specification, section 9.6).
#pragma once

#include "rack/proxies/proxy.h"

namespace rack {

struct GyroData {
  TimeStamp recordingTime = 0;
  Radians<f32> roll = 0;   // about x
  Radians<f32> pitch = 0;  // about y
  Radians<f32> yaw = 0;    // about z
  MillimetresPerSecond2<f32> aX = 0;
  MillimetresPerSecond2<f32> aY = 0;
  MillimetresPerSecond2<f32> aZ = 0;
  RadiansPerSecond<f32> wRoll = 0;
  RadiansPerSecond<f32> wPitch = 0;
  RadiansPerSecond<f32> wYaw = 0;
};

using GyroProxy = DataProxy<GyroData, tims::class_id::kGyro>;

}  // namespace rack
