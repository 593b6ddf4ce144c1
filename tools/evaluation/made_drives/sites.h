// Buildings for made drives, and routes through them. Pure.
//
// The laboratory: two rings of corridors that share one, with rooms of few sizes, which differ in
// their furniture only. The campus: three rings of corridors, up to 250 m long, with a door every
// five metres, and little else; the drive takes the longest corridor three times.
#pragma once

#include <cstdint>
#include <vector>

#include "components/geometry/floor_map.h"
#include "tools/evaluation/made_drives/carved_floor.h"

namespace rack::made_drives {

struct Site {
  CarvedFloor floor;
  std::vector<MapPoint> route{};  // m, corners of the way of the robot; x to the east
};

Site laboratory(std::uint64_t seed);
Site campus(std::uint64_t seed);

}  // namespace rack::made_drives
