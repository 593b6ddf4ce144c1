#include "tools/evaluation/made_drives/carved_floor.h"

#include <algorithm>
#include <cmath>

namespace rack::made_drives {

CarvedFloor::CarvedFloor(double width, double height)
    : columns_(std::llround(width / kCell)),
      rows_(std::llround(height / kCell)),
      free_(static_cast<std::size_t>(columns_ * rows_)) {}

void CarvedFloor::fill(double x, double y, double x2, double y2, bool free) {
  const auto cell = [](double at, std::int64_t limit) {
    return std::clamp<std::int64_t>(std::llround(at / kCell), 0, limit);
  };
  for (std::int64_t row = cell(y, rows_); row < cell(y2, rows_); ++row)
    for (std::int64_t column = cell(x, columns_); column < cell(x2, columns_); ++column)
      free_[static_cast<std::size_t>(row * columns_ + column)] = free ? 1 : 0;
}

bool CarvedFloor::at(std::int64_t column, std::int64_t row) const {
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return false;
  return free_[static_cast<std::size_t>(row * columns_ + column)] != 0;
}

bool CarvedFloor::is_free(double x, double y) const {
  return at(static_cast<std::int64_t>(std::floor(x / kCell)),
            static_cast<std::int64_t>(std::floor(y / kCell)));
}

DxfDrawing CarvedFloor::walls() const {
  DxfDrawing drawing;
  const auto m = [](std::int64_t cells) { return static_cast<double>(cells) * kCell; };
  for (std::int64_t row = 0; row <= rows_; ++row)
    for (std::int64_t column = 0; column < columns_; ++column) {
      const std::int64_t begin = column;
      while (column < columns_ && at(column, row) != at(column, row - 1) &&
             at(column, row) == at(begin, row))
        ++column;
      if (column > begin) {
        drawing.lines.push_back({{m(begin), m(row)}, {m(column), m(row)}});
        --column;
      }
    }
  for (std::int64_t column = 0; column <= columns_; ++column)
    for (std::int64_t row = 0; row < rows_; ++row) {
      const std::int64_t begin = row;
      while (row < rows_ && at(column, row) != at(column - 1, row) &&
             at(column, row) == at(column, begin))
        ++row;
      if (row > begin) {
        drawing.lines.push_back({{m(column), m(begin)}, {m(column), m(row)}});
        --row;
      }
    }
  return drawing;
}

}  // namespace rack::made_drives
