// A floor plan that is carved out of a solid block: corridors and rooms are rectangles of free
// space, furniture is put back. The walls are the borders between the two. Pure.
#pragma once

#include <cstdint>
#include <vector>

#include "components/geometry/dxf.h"

namespace rack::made_drives {

class CarvedFloor {
 public:
  // In metres, x to the east and y to the north.
  CarvedFloor(double width, double height);

  void carve(double x, double y, double x2, double y2) { fill(x, y, x2, y2, true); }
  void put(double x, double y, double x2, double y2) { fill(x, y, x2, y2, false); }
  [[nodiscard]] bool is_free(double x, double y) const;
  // Borders in a row are one line.
  [[nodiscard]] DxfDrawing walls() const;

 private:
  static constexpr double kCell = 0.1;  // m
  void fill(double x, double y, double x2, double y2, bool free);
  [[nodiscard]] bool at(std::int64_t column, std::int64_t row) const;

  std::int64_t columns_;
  std::int64_t rows_;
  std::vector<std::uint8_t> free_;
};

}  // namespace rack::made_drives
