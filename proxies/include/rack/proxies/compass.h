// Direction of north (specification, section 9.4).
#pragma once

#include "rack/proxies/proxy.h"

namespace rack {

struct CompassData {
  TimeStamp recordingTime = 0;
  Radians<f32> orientation = 0;     // 0: magnetic north
  Radians<f32> varOrientation = 0;  // standard deviation
};

using CompassProxy = DataProxy<CompassData, tims::class_id::kCompass>;

}  // namespace rack
