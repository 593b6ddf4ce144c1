#include "components/mapping/occupancy.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace rack::mapping {

namespace {

using localisation::Cell;
using localisation::GridMap;

constexpr double kOccupiedShare = 0.25;  // share of beams that end; many pass the edge of a wall
constexpr std::uint32_t kFreeLeast = 2;  // beams

}  // namespace

tims::Result<Occupancy> Occupancy::of(double resolution, const MapPoint& low,
                                      const MapPoint& high) {
  const double rows = std::floor((high.x - low.x) / resolution) + 1;
  const double columns = std::floor((high.y - low.y) / resolution) + 1;
  if (std::isnan(rows) || std::isnan(columns) || rows < 1 || columns < 1)
    return tims::Error(tims::Errc::kMalformed, "the map has no size");
  const double wanted = rows * columns;
  if (wanted > static_cast<double>(GridMap::kCellsMax))
    return tims::Error(tims::Errc::kTooBig,
                       "the map would be " + std::to_string(std::llround((high.x - low.x) / 1000)) +
                           " m x " + std::to_string(std::llround((high.y - low.y) / 1000)) +
                           " m, more than " + std::to_string(GridMap::kCellsMax) +
                           " cells: use larger cells or shorter beams");
  Occupancy occupancy;
  occupancy.map_ = {.resolution = resolution,
                    .origin = low,
                    .rows = static_cast<std::int32_t>(rows),
                    .columns = static_cast<std::int32_t>(columns)};
  occupancy.counts_.resize(static_cast<std::size_t>(wanted));
  return occupancy;
}

Occupancy::Counts* Occupancy::at(std::int64_t row, std::int64_t column) {
  if (row < 0 || column < 0 || row >= map_.rows || column >= map_.columns) return nullptr;
  return &counts_[static_cast<std::size_t>(row * map_.columns + column)];
}

// Steps from one cell border to the next (Amanatides and Woo 1987).
void Occupancy::add_beam(const MapPoint& from, const MapPoint& to) {
  const double x = (from.x - map_.origin.x) / map_.resolution;
  const double y = (from.y - map_.origin.y) / map_.resolution;
  const double dx = (to.x - from.x) / map_.resolution;
  const double dy = (to.y - from.y) / map_.resolution;
  if (!(std::abs(x) + std::abs(y) + std::abs(dx) + std::abs(dy) < 1e6)) return;
  auto row = static_cast<std::int64_t>(std::floor(x));
  auto column = static_cast<std::int64_t>(std::floor(y));
  const auto last_row = static_cast<std::int64_t>(std::floor(x + dx));
  const auto last_column = static_cast<std::int64_t>(std::floor(y + dy));
  const std::int64_t row_step = dx < 0 ? -1 : 1;
  const std::int64_t column_step = dy < 0 ? -1 : 1;
  const double row_each = dx == 0 ? 1e18 : 1 / std::abs(dx);
  const double column_each = dy == 0 ? 1e18 : 1 / std::abs(dy);
  const auto to_border = [](double at, double extent) {
    return extent < 0 ? at - std::floor(at) : std::floor(at) + 1 - at;
  };
  double next_row = to_border(x, dx) * row_each;
  double next_column = to_border(y, dy) * column_each;
  std::int64_t left = std::abs(last_row - row) + std::abs(last_column - column);
  for (; left > 0; --left) {
    if (Counts* counts = at(row, column)) ++counts->passed;
    if (next_row < next_column) {
      row += row_step;
      next_row += row_each;
    } else {
      column += column_step;
      next_column += column_each;
    }
  }
  if (Counts* counts = at(last_row, last_column)) ++counts->ended;
  if (next_row < next_column) {
    row += row_step;
  } else {
    column += column_step;
  }
  if (Counts* counts = at(row, column)) ++counts->behind;
}

GridMap Occupancy::map() const {
  GridMap map = map_;
  map.cells.reserve(counts_.size());
  for (const Counts& counts : counts_) {
    const double all = counts.ended + counts.passed + counts.behind;
    Cell cell = Cell::kUnknown;
    if (counts.ended > 0 && counts.ended >= kOccupiedShare * all) {
      cell = Cell::kOccupied;
    } else if (counts.passed >= kFreeLeast) {
      cell = Cell::kFree;
    }
    map.cells.push_back(cell);
  }
  return map;
}

}  // namespace rack::mapping
