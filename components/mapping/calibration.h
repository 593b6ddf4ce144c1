// The systematic errors of an odometry, from the scans of the drive. Pure.
//
// Wheels are smaller than believed, one more than the other, the scanner is mounted a degree off:
// each step is wrong in the same direction. Where the scans see enough walls they measure the steps
// better than the wheels, and from all these steps follow the errors, by robust least squares.
// Along bare corridors, where scans measure nothing, the corrected odometry is much better than the
// recorded one (Censi, Franchi, Marchionni, Oriolo 2013).
#pragma once

#include "components/mapping/keyframes.h"

namespace rack::mapping {

struct Calibration {
  double scale = 1;       // true distance by that of the odometry
  double aside = 0;       // mm to the right for each mm forward
  double turn_scale = 1;  // true turn by that of the odometry
  double drift = 0;       // rad for each mm forward

  [[nodiscard]] Pose corrected(const Pose& step) const;
};

// No change when the drive does not allow an estimate, or errors would be larger than any robot
// has: then something else is wrong.
Calibration calibrate(const Track& track);

// The drive with corrected odometry.
Drive corrected(Drive drive, const Calibration& calibration);

}  // namespace rack::mapping
