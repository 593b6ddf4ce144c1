// Position from odometry (specification, section 9.16).
#pragma once

#include "rack/proxies/geometry.h"
#include "rack/proxies/proxy.h"

namespace rack {

struct OdometryType {
  enum : i8 {
    kReset = 21,  // the position becomes 0
  };
};

struct OdometryData {
  TimeStamp recordingTime = 0;
  Position3d pos = {};  // in the odometry frame
};

class OdometryProxy : public DataProxy<OdometryData, tims::class_id::kOdometry> {
 public:
  using DataProxy::DataProxy;

  Result<void> reset() { return command(OdometryType::kReset); }
};

}  // namespace rack
