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
  if (wanted > static_cast<double>(kCellsMax))
    return tims::Error(tims::Errc::kTooBig,
                       "the map would be " + std::to_string(std::llround((high.x - low.x) / 1000)) +
                           " m x " + std::to_string(std::llround((high.y - low.y) / 1000)) +
                           " m, more than " + std::to_string(kCellsMax) +
                           " cells: use larger cells or shorter beams");
  Occupancy occupancy;
  occupancy.map_ = {.resolution = resolution,
                    .origin = low,
                    .rows = static_cast<std::int32_t>(rows),
                    .columns = static_cast<std::int32_t>(columns)};
  const auto tiles = [](std::int64_t cells) { return (cells + kTile - 1) / kTile; };
  occupancy.tiles_in_row_ = tiles(occupancy.map_.columns);
  occupancy.tiles_.resize(
      static_cast<std::size_t>(tiles(occupancy.map_.rows) * occupancy.tiles_in_row_));
  return occupancy;
}

Occupancy::Counts* Occupancy::at(std::int64_t row, std::int64_t column) {
  if (row < 0 || column < 0 || row >= map_.rows || column >= map_.columns) return nullptr;
  Tile& tile = tiles_[static_cast<std::size_t>(row / kTile * tiles_in_row_ + column / kTile)];
  if (tile.empty()) tile.resize(kTile * kTile);
  return &tile[static_cast<std::size_t>(row % kTile * kTile + column % kTile)];
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

Cell Occupancy::cell_of(const Counts& counts) {
  const double all = counts.ended + counts.passed + counts.behind;
  if (counts.ended > 0 && counts.ended >= kOccupiedShare * all) return Cell::kOccupied;
  return counts.passed >= kFreeLeast ? Cell::kFree : Cell::kUnknown;
}

GridMap Occupancy::map() const {
  GridMap map = map_;
  map.cells.assign(static_cast<std::size_t>(map.rows) * static_cast<std::size_t>(map.columns),
                   Cell::kUnknown);
  for (std::size_t i = 0; i < tiles_.size(); ++i) {
    const std::int64_t low_row = static_cast<std::int64_t>(i) / tiles_in_row_ * kTile;
    const std::int64_t low_column = static_cast<std::int64_t>(i) % tiles_in_row_ * kTile;
    for (std::size_t k = 0; k < tiles_[i].size(); ++k) {
      const std::int64_t row = low_row + static_cast<std::int64_t>(k) / kTile;
      const std::int64_t column = low_column + static_cast<std::int64_t>(k) % kTile;
      if (row < map.rows && column < map.columns)
        map.cells[static_cast<std::size_t>(row * map.columns + column)] = cell_of(tiles_[i][k]);
    }
  }
  return map;
}

}  // namespace rack::mapping
