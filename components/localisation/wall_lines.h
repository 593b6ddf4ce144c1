// The walls of a map as lines that a scan is laid on: for each cell near a wall, the nearest one.
// Pure.
//
// Of a floor plan they are its own lines, in pieces. Of cells a line is laid through each occupied
// one and its occupied neighbours (the long axis of their scatter), so that it is known better than
// to a cell; cells that lie on no line, in corners and bushes, are none. Cells are kept in squares
// of 16 x 16, and only those near walls: a large map is mostly empty.
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

  // Standard deviation of where a line is, mm: the cells' part of it.
  [[nodiscard]] double error() const { return error_; }
  [[nodiscard]] std::size_t size() const { return lines_.size(); }

  static constexpr double kReach = 600;  // mm

 private:
  static constexpr std::int32_t kSquare = 16;  // cells
  static constexpr std::size_t kSquareCells = 256;

  void add_plan(const GridMap& map);
  void add_cells(const GridMap& map);
  // A piece of a wall: its middle, direction and length.
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
  std::vector<std::uint32_t> squares_;  // 0: no wall near it; else which, from 1
  std::vector<std::uint32_t> nearest_;  // of the cells of these: 0: none; else which line, from 1
  std::vector<float> distances_;        // squared, while they are made
  std::vector<ScanPoint2d> lines_;
};

}  // namespace rack::localisation
