// Reads routes of the DARPA Grand Challenge. A Route Definition Data File is text with one waypoint
// per line: number, latitude and longitude (WGS84, degrees), lateral boundary offset (feet), speed
// limit (miles per hour), and up to three unused fields. Offset and limit of a line apply to the
// leg that starts there; the last line has limit 0: the finish. Files written by hand may contain
// comments (#) and blanks, and omit the last fields. In RACK's waypoints, both apply to the leg
// that ends there, in metric units. Pure.
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

// The error kMalformed names the line; kTooBig: more than kWaypointsMax.
tims::Result<std::vector<RddfPoint>> read_rddf(std::string_view text);

// Converts a place on Earth to the world of the robot: Coordinates::from(), or a request to
// Position.
using ToWorld = std::function<tims::Result<PositionData>(const PositionWgs84Data&)>;

tims::Result<std::vector<Waypoint2d>> to_waypoints(std::span<const RddfPoint> points,
                                                   const ToWorld& to_world);

}  // namespace rack::path
