// The static objects of a world: walls and obstacles in a uniform grid. A ray visits the cells on
// its path from near to far (Amanatides and Woo 1987) and ends in the first cell with a hit. Each
// cell has a list of the figures it touches; all lists are contiguous in one array.
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
    double range = kNoHit;  // distance over ground
    Met met = Met::kNothing;
  };
  // The nearest hit of the ray within its range.
  [[nodiscard]] Hit cast(const Ray& ray) const;
  // Distance to the nearest object, at most `most`.
  [[nodiscard]] double clearance(const MapPoint& at, double most) const;
  // The kind of object that the box overlaps, or kNothing.
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
  // Index of a figure: walls first, then solids.
  using Number = std::uint32_t;

  void make_cells();
  void fill();
  template <typename Visit>
  void cells_of(Number figure, const Visit& visit) const;
  [[nodiscard]] Cell cell_of(const MapPoint& at) const;
  [[nodiscard]] std::span<const Number> at(const Cell& cell) const;
  // Visits each figure of the cells that a square touches, some more than once.
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
