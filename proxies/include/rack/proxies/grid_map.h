// A map of grid cells (specification, section 9.14).
#pragma once

#include <array>

#include "rack/proxies/proxy.h"

namespace rack {

struct GridMapData {
  TimeStamp recordingTime = 0;
  Millimetres<i32> offsetX = 0;  // position of cell (0, 0)
  Millimetres<i32> offsetY = 0;
  Quantity<i32, unit::MillimetrePerCell> scale = 0;
  i32 gridNumX = 0;  // cells
  i32 gridNumY = 0;
  Tail<u8, 250000> occupancy = {};  // 0: free to 255: occupied

  [[nodiscard]] std::array<std::int64_t, 1> tail_sizes() const {
    if (gridNumX < 0 || gridNumY < 0) return {-1};
    return {std::int64_t{gridNumX} * gridNumY};
  }
};

using GridMapProxy = DataProxy<GridMapData, tims::class_id::kGridMap>;

}  // namespace rack
