// Routes as the DARPA Grand Challenge gave them out: a Route Definition Data File is text, a
// waypoint a line: number, latitude and longitude (WGS84, degrees), lateral boundary offset (feet),
// speed limit (miles an hour), and up to three fields that nobody needs any more. Offset and limit
// of a line are those of the leg that begins there; the last line has limit 0: the finish. Teams
// wrote such files by hand, too: with comments (#), blanks, and without the last fields. RACK's
// waypoints say it of the leg that ends there, in metric units. Pure.
#pragma once

#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "rack/proxies/path.h"
#include "rack/proxies/position.h"
#include "tims/result.h"

namespace rack::path {

inline constexpr std::size_t kWaypointsMax = 6000;

struct RddfPoint {
  i32 number = 0;
  double latitude = 0;   // rad
  double longitude = 0;  // rad
  double offset = 0;     // to each side, mm
  double speed = 0;      // mm/s
};

// kMalformed says which line is none; kTooBig: more than kWaypointsMax.
tims::Result<std::vector<RddfPoint>> read_rddf(std::string_view text);

// A place on Earth in the world of the robot: Coordinates::from(), or a Position that is asked.
using ToWorld = std::function<tims::Result<PositionData>(const PositionWgs84Data&)>;

tims::Result<std::vector<Waypoint2d>> to_waypoints(std::span<const RddfPoint> points,
                                                   const ToWorld& to_world);

}  // namespace rack::path
