// Raw data of a laser range finder in polar coordinates (specification, section 9.9).
#pragma once

#include "rack/proxies/proxy.h"

namespace rack {

struct LadarPoint {
  Radians<f32> angle = 0;  // clockwise
  Millimetres<i32> distance = 0;
  i32 type = 0;  // a ladar_point value
  i32 intensity = 0;
};

namespace ladar_point {
inline constexpr i32 kUnknown = 0;
inline constexpr i32 kTransparent = 1;
inline constexpr i32 kRain = 2;
inline constexpr i32 kDirt = 3;
inline constexpr i32 kInvalid = 0x10;
inline constexpr i32 kReflector = 0x80;
}  // namespace ladar_point

struct LadarData {
  TimeStamp recordingTime = 0;
  Milliseconds<u32> duration = 0;  // of the scan
  Millimetres<i32> maxRange = 0;
  Radians<f32> startAngle = 0;  // sensor frame, clockwise
  Radians<f32> endAngle = 0;
  Count pointNum = {};
  Sequence<LadarPoint, 2160> points = {};
};

using LadarProxy = DataProxy<LadarData, tims::class_id::kLadar>;

}  // namespace rack
