// A planar scan as points in the robot frame (specification, section 9.21).
#pragma once

#include "rack/proxies/geometry.h"
#include "rack/proxies/proxy.h"

namespace rack {

struct Scan2dData {
  TimeStamp recordingTime = 0;
  Milliseconds<u32> duration = 0;
  Millimetres<i32> maxRange = 0;
  i32 sectorNum = 1;  // 1: the scan is sent as a whole
  i32 sectorIndex = 0;
  Position3d refPos = {};  // frame of the points; all zero: the robot frame
  Count pointNum = {};
  Sequence<ScanPoint, 8000> points = {};
};

using Scan2dProxy = DataProxy<Scan2dData, tims::class_id::kScan2d>;

}  // namespace rack
