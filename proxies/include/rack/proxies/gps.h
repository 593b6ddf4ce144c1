// A satellite navigation receiver (specification, section 9.5).
#pragma once

#include "rack/proxies/geometry.h"
#include "rack/proxies/proxy.h"

namespace rack {

namespace gps_mode {
inline constexpr i32 kInvalid = 0;
inline constexpr i32 k2d = 1;
inline constexpr i32 k3d = 2;
inline constexpr i32 kDifferential = 0x10;  // added to one of the above
inline constexpr i32 kEstimated = 0x20;
}  // namespace gps_mode

struct GpsData {
  TimeStamp recordingTime = 0;
  i32 mode = gps_mode::kInvalid;
  Radians<f64> latitude = 0;  // WGS84
  Radians<f64> longitude = 0;
  Millimetres<i32> altitude = 0;  // above the sea, up
  Radians<f32> heading = 0;       // 0: north
  MillimetresPerSecond<i32> speed = 0;
  i32 satelliteNum = 0;
  Seconds<i64> utcTime = 0;  // since 1970
  f32 pdop = 0;              // dilution of precision
  Position3d pos = {};       // global
  Position3d var = {};       // standard deviations
};

using GpsProxy = DataProxy<GpsData, tims::class_id::kGps>;

}  // namespace rack
