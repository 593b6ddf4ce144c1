// Classifies the cells of a map as free or occupied by counting the beams that end in a cell and
// those that pass through it (Haehnel, Burgard, Fox, Thrun 2003, "reflection probability"). People
// disappear, as later beams pass through their cells. Because of range noise, some beams that end
// at a wall appear to end a cell before it, others a cell behind it. The cell before the wall is
// passed by the other beams, but the cell behind it would not be, and each wall would be a cell too
// thick on the far side. So a beam also counts as a pass for the cell behind its end. Pure.
#pragma once

#include <span>
#include <vector>

#include "components/geometry/pose.h"
#include "components/localisation/grid_map.h"
#include "components/localisation/likelihood_field.h"
#include "tims/result.h"

namespace rack::mapping {

class Occupancy {
 public:
  // 560 m x 560 m with cells of 50 mm: what readers of maps take (pictures::kGreyPixelsMax).
  static constexpr std::int64_t kCellsMax = 128'000'000;

  // Refuses a map with more than kCellsMax cells, or of size 0.
  static tims::Result<Occupancy> of(double resolution, const MapPoint& low, const MapPoint& high);

  void add_beam(const MapPoint& from, const MapPoint& to);
  [[nodiscard]] localisation::GridMap map() const;

 private:
  struct Counts {
    std::uint32_t ended = 0;
    std::uint32_t passed = 0;
    std::uint32_t behind = 0;  // beams that ended in the cell before it
  };
  // Most of a large map is never seen: only tiles with beams have counts.
  static constexpr std::int64_t kTile = 64;
  using Tile = std::vector<Counts>;
  static localisation::Cell cell_of(const Counts& counts);
  Occupancy() = default;
  [[nodiscard]] Counts* at(std::int64_t row, std::int64_t column);

  localisation::GridMap map_{};
  std::int64_t tiles_in_row_ = 0;
  std::vector<Tile> tiles_;
};

}  // namespace rack::mapping
