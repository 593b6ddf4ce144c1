// Marks the points of a scan that are on moving objects (specification, section 10.4). Pure.
//
// Objects are boxes in the robot's frame, some time before or after the scan: each is moved by its
// speed to the time of the scan, and by the motion of the robot since then. A point inside the box
// of an object that is fast enough becomes a dynamic obstacle: pilots brake earlier for it, and
// localisation ignores it.
#pragma once

#include "rack/proxies/obj_recog.h"
#include "rack/proxies/scan2d.h"

namespace rack::perception {

inline constexpr i32 kDynamicObstacle = 3;

struct MovingPoints {
  double speed_min = 300;  // mm/s
  double margin = 100;     // mm around a box: noise of both
};

// Returns the number of points marked. Objects whose time differs from the scan's by more than a
// second are ignored.
std::size_t mark_moving(const ObjRecogData& objects, const MovingPoints& settings,
                        Scan2dData& scan);

}  // namespace rack::perception
