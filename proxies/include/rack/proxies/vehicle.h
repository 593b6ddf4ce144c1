// A car, controlled by its pedals and steering wheel (specification, section 9.12).
#pragma once

#include "rack/proxies/proxy.h"

namespace rack {

struct VehicleType {
  enum : i8 {
    kSetValue = 21,  // VehicleSetValueData
  };
};

inline constexpr i32 kInvalidGear = -255;

struct VehicleData {
  TimeStamp recordingTime = 0;
  MillimetresPerSecond<i32> speed = 0;
  RadiansPerSecond<f32> omega = 0;
  Percent<f32> throttle = 0;  // 0 to 100
  Percent<f32> brake = 0;     // 0 to 100
  Percent<f32> clutch = 0;    // 0 to 100
  Percent<f32> steering = 0;  // -100 to 100
  i32 gear = 0;               // below 0: reverse; 0: neutral; kInvalidGear
  i32 engine = 0;             // 1: running
  i32 parkBrake = 0;          // 1: on
  i32 vehicleProtect = 0;     // 1: on
  u32 activeController = 0;
};

struct VehicleSetValueData {
  Percent<f32> throttle = 0;
  Percent<f32> brake = 0;
  Percent<f32> clutch = 0;
  Percent<f32> steering = 0;
  i32 gear = 0;
  i32 engine = 0;
  i32 parkBrake = 0;
  i32 vehicleProtect = 0;
  u32 activeController = 0;
};

class VehicleProxy : public DataProxy<VehicleData, tims::class_id::kVehicle> {
 public:
  using DataProxy::DataProxy;

  Result<void> set_value(const VehicleSetValueData& value) {
    return command(VehicleType::kSetValue, value);
  }
};

}  // namespace rack
