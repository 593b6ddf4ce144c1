// The walls of a map as lines for scan matching: for each cell near a wall, the nearest line. Pure.
//
// For a floor plan these are its own lines, in pieces. For a grid, a line is fitted through each
// occupied cell and its occupied neighbours (the major axis of their scatter), so that its position
// is more exact than a cell. Cells that are not on a line (corners, bushes) have none. Cells are
// stored in squares of 16 x 16, and only those near walls: a large map is mostly empty.
#pragma once

#include <cstdint>
#include <vector>

#include "components/localisation/grid_map.h"
#include "components/localisation/line_match.h"

namespace rack::localisation {

class WallLines final : public Lines {
 public:
  WallLines() = default;
  explicit WallLines(const GridMap& map);

  [[nodiscard]] bool empty() const override { return lines_.empty(); }
  [[nodiscard]] const ScanPoint2d* nearest(const ScanPoint2d& point, float reach) const override;

  // Standard deviation of the position of a line due to the cell size, mm.
  [[nodiscard]] double error() const { return error_; }
  [[nodiscard]] std::size_t size() const { return lines_.size(); }

  static constexpr double kReach = 600;  // mm

 private:
  static constexpr std::int32_t kSquare = 16;  // cells
  static constexpr std::size_t kSquareCells = 256;

  void add_plan(const GridMap& map);
  void add_cells(const GridMap& map);
  // Adds a piece of a wall: its midpoint, normal and length.
  void add(const ScanPoint2d& line, double length);
  void put(std::int32_t row, std::int32_t column, float square);

  float low_x_ = 0;
  float low_y_ = 0;
  float cells_per_mm_ = 0;
  std::int32_t rows_ = 0;
  std::int32_t columns_ = 0;
  std::int32_t square_columns_ = 0;
  double error_ = 0;
  double resolution_ = 0;
  std::vector<std::uint32_t> squares_;  // 0: no wall near it; else index + 1
  std::vector<std::uint32_t> nearest_;  // of their cells: 0: none; else index of the line + 1
  std::vector<float> distances_;        // squared; only used during construction
  std::vector<ScanPoint2d> lines_;
};

}  // namespace rack::localisation
