// What a marker looks like: its cells, by libapriltag. Pure.
#pragma once

#include <cstdint>
#include <vector>

#include "components/vision/marker_map.h"
#include "tims/result.h"

namespace rack::vision {

struct MarkerPicture {
  int side = 0;                       // cells, with the white border
  double whole = 1;                   // side with the white border, for a marker of size 1
  std::vector<std::uint8_t> cells{};  // row by row from the top left: 0 black, 255 white
};

// kInvalidArgument: there is no such marker.
tims::Result<MarkerPicture> picture_of(const Marker& marker);

}  // namespace rack::vision
