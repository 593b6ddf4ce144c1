// What stands in a world: walls and obstacles that never move, in a uniform grid of cells, so that
// a ray tries only what lies in the cells it goes through, from the near ones to the far ones
// (Amanatides and Woo 1987), and ends in the first cell where it has met something. A figure is in
// the list of each cell it touches; the lists lie behind each other in one array.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "components/world/core/shapes.h"
#include "components/world/core/world.h"

namespace rack::world {

class Scenery {
 public:
  Scenery() = default;
  Scenery(std::span<const WallDescription> walls, std::span<const ObstacleDescription> obstacles);

  struct Hit {
    double way = kNoHit;  // over ground
    Met met = Met::kNothing;
  };
  // The nearest that the ray meets within its reach.
  [[nodiscard]] Hit cast(const Ray& ray) const;
  // How far the nearest of it is, at most `most`.
  [[nodiscard]] double clearance(const MapPoint& at, double most) const;
  // What of it the box overlaps, or nothing.
  [[nodiscard]] Met touches(const Box& box) const;

 private:
  struct Wall {
    Segment segment;
    double height;
  };
  struct Cell {
    std::int64_t x = 0;
    std::int64_t y = 0;
  };
  // Of a figure: walls first, then solids.
  using Number = std::uint32_t;

  void make_cells();
  void fill();
  template <typename Visit>
  void cells_of(Number figure, const Visit& visit) const;
  [[nodiscard]] Cell cell_of(const MapPoint& at) const;
  [[nodiscard]] std::span<const Number> at(const Cell& cell) const;
  // Each figure of the cells that a square touches, some more than once.
  template <typename Visit>
  void near(const MapPoint& middle, double reach, const Visit& visit) const;
  void try_cell(const Ray& ray, const Cell& cell, Hit& best) const;
  [[nodiscard]] bool is_wall(Number figure) const { return figure < walls_.size(); }
  [[nodiscard]] const Solid& solid(Number figure) const { return solids_[figure - walls_.size()]; }

  std::vector<Wall> walls_;
  std::vector<Solid> solids_;
  MapPoint origin_{};  // of the cells
  double cell_ = 1;    // mm
  std::int64_t rows_ = 0;
  std::int64_t columns_ = 0;
  std::vector<std::uint32_t> begins_;  // of each cell's list, and the end of the last
  std::vector<Number> lists_;
};

}  // namespace rack::world
