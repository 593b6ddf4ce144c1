// Where a vehicle is that tells how it has moved (specification, section 10.2). Pure.
//
// Each movement is relative to the vehicle as it was: it is turned by the heading so far, and
// added. Between two data sets the vehicle is taken to move at an even speed; angles go the short
// way round.
#pragma once

#include "components/geometry/pose.h"
#include "rack/proxies/chassis.h"
#include "rack/proxies/odometry.h"

namespace rack::navigation {

class DeadReckoning {
 public:
  explicit DeadReckoning(const Pose& start) : pose_(start) {}

  void reset() { pose_ = {}; }
  // Movements that are no numbers are left out.
  OdometryData add(const ChassisData& movement);

 private:
  Pose pose_;
};

// At `time`, between two data sets or on the straight line beyond them.
OdometryData interpolated(const OdometryData& before, const OdometryData& after, TimeStamp time);

}  // namespace rack::navigation
