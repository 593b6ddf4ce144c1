// Which points of a scan lie on objects that move (specification, section 10.4). Pure.
//
// Objects come as boxes in the robot's frame, some time before or after the scan: each is moved by
// its speed to the time of the scan, and by how far the robot itself has moved since. A point
// inside the box of one that is fast enough becomes a dynamic obstacle: pilots brake earlier for
// it, and localisation leaves it out.
#pragma once

#include "rack/proxies/obj_recog.h"
#include "rack/proxies/scan2d.h"

namespace rack::perception {

inline constexpr i32 kDynamicObstacle = 3;

struct MovingPoints {
  double speed_min = 300;  // mm/s
  double margin = 100;     // mm around a box: noise of both
};

// Returns how many. Objects of more than a second beside the scan's time are none of it.
std::size_t mark_moving(const ObjRecogData& objects, const MovingPoints& settings,
                        Scan2dData& scan);

}  // namespace rack::perception
