// A picture of a map with the drive through it, and what contradicts the map. Pure.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "components/mapping/map_maker.h"

namespace rack::map_maker {

struct ColourPicture {
  std::int32_t width = 0;
  std::int32_t height = 0;
  std::vector<std::byte> rgb{};
};

// Walls black, free space white, the drive blue, red: walls that are seen through, and the places
// of the robot there. Maps of more than 4000 cells on a side are reduced.
ColourPicture draw_doubts(const mapping::MadeMap& made);

}  // namespace rack::map_maker
