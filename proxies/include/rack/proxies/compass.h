// Where north is (specification, section 9.4).
#pragma once

#include "rack/proxies/proxy.h"

namespace rack {

struct CompassData {
  TimeStamp recordingTime = 0;
  Radians<f32> orientation = 0;     // 0: magnetic north
  Radians<f32> varOrientation = 0;  // standard deviation
};

class CompassProxy : public DataProxy<CompassData> {
 public:
  using DataProxy::DataProxy;
};

}  // namespace rack
