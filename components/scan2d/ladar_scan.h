// A laser scan as points of the robot (specification, section 10.4). Pure.
#pragma once

#include "proxies/ladar.h"
#include "proxies/scan2d.h"

namespace rack::scan2d {

struct LadarMounting {
  i32 x = 0;       // of the ladar on the robot, mm
  i32 y = 0;       // mm
  double rho = 0;  // rad
  bool upside_down = false;
};

struct ScanFilter {
  i32 range_max = 30000;     // mm
  i32 reduce = 1;            // each so many-th point
  double angle_min = -3.15;  // of the ladar, rad
  double angle_max = 3.15;   // rad
  bool median = false;       // of three: single points that stick out are noise
  bool reflectors = false;   // one alone is noise
};

// Allocates nothing once `scan` has the room. refPos stays as it is.
void convert(const LadarData& ladar, const LadarMounting& mounting, const ScanFilter& filter,
             Scan2dData& scan);

}  // namespace rack::scan2d
