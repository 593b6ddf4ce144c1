// Which cells of a map are free and which are occupied, by counting: how many beams ended in a
// cell, and how many went through it (Haehnel, Burgard, Fox, Thrun 2003, "reflection probability").
// People are counted through later and vanish. Ranges err: of the beams that end at a wall some
// seem to end a cell before it and some a cell behind. Before it the others pass through; behind it
// nothing would, and each wall would be a cell too thick, away from the robot. So a beam counts
// against the cell behind its end, as against those before. Pure.
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
  // Refused: a map with more cells than GridMap::kCellsMax, or of no size.
  static tims::Result<Occupancy> of(double resolution, const MapPoint& low, const MapPoint& high);

  void add_beam(const MapPoint& from, const MapPoint& to);
  [[nodiscard]] localisation::GridMap map() const;

 private:
  struct Counts {
    std::uint32_t ended = 0;
    std::uint32_t passed = 0;
    std::uint32_t behind = 0;  // ended just before it
  };
  Occupancy() = default;
  [[nodiscard]] Counts* at(std::int64_t row, std::int64_t column);

  localisation::GridMap map_{};
  std::vector<Counts> counts_;
};

}  // namespace rack::mapping
