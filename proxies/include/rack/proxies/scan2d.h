// A flat scan as points in the robot's frame (specification, section 9.21).
#pragma once

#include "rack/proxies/geometry.h"
#include "rack/proxies/proxy.h"

namespace rack {

struct Scan2dData {
  TimeStamp recordingTime = 0;
  Milliseconds<u32> duration = 0;
  Millimetres<i32> maxRange = 0;
  i32 sectorNum = 1;  // 1: the scan comes as a whole
  i32 sectorIndex = 0;
  Position3d refPos = {};  // of the points; all zero: the robot's frame
  Count pointNum = {};
  Sequence<ScanPoint, 8000> points = {};
};

using Scan2dProxy = DataProxy<Scan2dData>;

}  // namespace rack
