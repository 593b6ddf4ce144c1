#include "components/localisation/wall_lines.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "components/geometry/scatter.h"

namespace rack::localisation {

namespace {

constexpr double kPiece = 200;                // mm, length of the pieces of a plan's wall
constexpr float kSameWall = 0.7F;             // cosine of the angle between normals
constexpr double kWallLinesNeighbours = 250;  // mm: cells that a line is fitted through
// In cells: the maximum distance of a straight wall's cells across their line, and along it.
constexpr double kBesideMost = 0.75;
constexpr double kAlongLeast = 1.0;
// Error of a line that is fitted through cells, in cells.
constexpr double kCellError = 0.1;

bool is_edge(const GridMap& map, std::int32_t row, std::int32_t column) {
  if (map.at(row, column) != Cell::kOccupied) return false;
  if (row == 0 || column == 0 || row + 1 == map.rows || column + 1 == map.columns) return true;
  return map.at(row - 1, column) != Cell::kOccupied || map.at(row + 1, column) != Cell::kOccupied ||
         map.at(row, column - 1) != Cell::kOccupied || map.at(row, column + 1) != Cell::kOccupied;
}

// The line through the edge cells around a cell, in cells relative to it.
std::optional<ScanPoint2d> line_at(const GridMap& map, std::int32_t row, std::int32_t column,
                                   std::int32_t around) {
  Scatter edge;
  for (std::int32_t r = std::max(0, row - around); r <= std::min(map.rows - 1, row + around); ++r)
    for (std::int32_t c = std::max(0, column - around);
         c <= std::min(map.columns - 1, column + around); ++c) {
      if (!is_edge(map, r, c)) continue;
      edge.add(r - row, c - column);
    }
  if (edge.points() < 3) return std::nullopt;
  const auto [lengthwise, wide] = edge.variances();
  if (wide > kBesideMost * kBesideMost || lengthwise < kAlongLeast * kAlongLeast ||
      lengthwise < 3 * wide)
    return std::nullopt;
  const double along = edge.direction();
  const double nx = -std::sin(along);
  const double ny = std::cos(along);
  const double beside = nx * edge.mean().x + ny * edge.mean().y;
  return ScanPoint2d{static_cast<float>(beside * nx), static_cast<float>(beside * ny),
                     static_cast<float>(nx), static_cast<float>(ny)};
}

}  // namespace

WallLines::WallLines(const GridMap& map)
    : low_x_(static_cast<float>(map.origin.x)),
      low_y_(static_cast<float>(map.origin.y)),
      cells_per_mm_(static_cast<float>(1 / map.resolution)),
      rows_(map.rows),
      columns_(map.columns),
      square_columns_((map.columns + kSquare - 1) / kSquare),
      resolution_(map.resolution) {
  const auto square_rows = static_cast<std::size_t>((map.rows + kSquare - 1) / kSquare);
  squares_.assign(square_rows * static_cast<std::size_t>(square_columns_), 0);
  if (map.walls.empty()) {
    add_cells(map);
    error_ = kCellError * map.resolution;
  } else {
    add_plan(map);
  }
  distances_ = {};
}

void WallLines::add_plan(const GridMap& map) {
  for (const MapLine& wall : map.walls) {
    const double dx = wall.to.x - wall.from.x;
    const double dy = wall.to.y - wall.from.y;
    const double length = std::hypot(dx, dy);
    if (!(length >= 1)) continue;
    const double pieces = std::ceil(length / kPiece);
    const auto count = static_cast<std::int64_t>(pieces);
    for (std::int64_t i = 0; i < count; ++i) {
      const double part = (static_cast<double>(i) + 0.5) / pieces;
      add({static_cast<float>(wall.from.x + dx * part), static_cast<float>(wall.from.y + dy * part),
           static_cast<float>(-dy / length), static_cast<float>(dx / length)},
          length / pieces);
    }
  }
}

void WallLines::add_cells(const GridMap& map) {
  const auto around = static_cast<std::int32_t>(
      std::clamp(std::round(kWallLinesNeighbours / map.resolution), 2.0, 10.0));
  for (std::int32_t row = 0; row < map.rows; ++row)
    for (std::int32_t column = 0; column < map.columns; ++column) {
      if (!is_edge(map, row, column)) continue;
      auto line = line_at(map, row, column, around);
      if (!line) line = line_at(map, row, column, std::max(2, around / 2));
      if (!line) continue;
      const auto place = [&](double origin, std::int32_t cell, float beside) {
        return static_cast<float>(origin +
                                  (cell + 0.5 + static_cast<double>(beside)) * map.resolution);
      };
      add({place(map.origin.x, row, line->x), place(map.origin.y, column, line->y), line->nx,
           line->ny},
          0);
    }
}

void WallLines::add(const ScanPoint2d& line, double length) {
  lines_.push_back(line);
  const auto to_cells = [&](float at, float low) {
    return static_cast<double>((at - low) * cells_per_mm_) - 0.5;
  };
  // In cells, from the centre of the first one.
  const double x = to_cells(line.x, low_x_);
  const double y = to_cells(line.y, low_y_);
  const double half = length / 2 / resolution_;
  const double reach = kReach / resolution_ + 1;
  const auto first = [&](double at) {
    return static_cast<std::int32_t>(std::max(0.0, std::ceil(at - half - reach)));
  };
  const auto last = [&](double at, std::int32_t count) {
    return static_cast<std::int32_t>(std::min(count - 1.0, std::floor(at + half + reach)));
  };
  const auto ax = static_cast<double>(line.ny);
  const auto ay = -static_cast<double>(line.nx);
  for (std::int32_t row = first(x); row <= last(x, rows_); ++row)
    for (std::int32_t column = first(y); column <= last(y, columns_); ++column) {
      const double along = std::clamp((row - x) * ax + (column - y) * ay, -half, half);
      const double dx = row - x - along * ax;
      const double dy = column - y - along * ay;
      const double square = dx * dx + dy * dy;
      if (square <= reach * reach) put(row, column, static_cast<float>(square));
    }
}

// Assigns the newest line to the cell if it is the nearest.
void WallLines::put(std::int32_t row, std::int32_t column, float square) {
  std::uint32_t& which = squares_[static_cast<std::size_t>(row / kSquare * square_columns_) +
                                  static_cast<std::size_t>(column / kSquare)];
  if (which == 0) {
    nearest_.resize(nearest_.size() + kSquareCells, 0);
    distances_.resize(nearest_.size(), std::numeric_limits<float>::infinity());
    which = static_cast<std::uint32_t>(nearest_.size() / kSquareCells);
  }
  const std::size_t at = (which - 1) * kSquareCells +
                         static_cast<std::size_t>(row % kSquare * kSquare + column % kSquare);
  if (square >= distances_[at]) return;
  distances_[at] = square;
  nearest_[at] = static_cast<std::uint32_t>(lines_.size());
}

const ScanPoint2d* WallLines::nearest(const ScanPoint2d& point, float reach) const {
  const float x = (point.x - low_x_) * cells_per_mm_;
  const float y = (point.y - low_y_) * cells_per_mm_;
  // Also false when a coordinate is not a number.
  const bool is_inside =
      x >= 0 && y >= 0 && x < static_cast<float>(rows_) && y < static_cast<float>(columns_);
  if (!is_inside) return nullptr;
  const auto row = static_cast<std::int32_t>(x);
  const auto column = static_cast<std::int32_t>(y);
  const std::uint32_t which = squares_[static_cast<std::size_t>(row / kSquare * square_columns_) +
                                       static_cast<std::size_t>(column / kSquare)];
  if (which == 0) return nullptr;
  const std::uint32_t found =
      nearest_[(which - 1) * kSquareCells +
               static_cast<std::size_t>(row % kSquare * kSquare + column % kSquare)];
  if (found == 0) return nullptr;
  const ScanPoint2d& line = lines_[found - 1];
  // Both sides of a thin wall are one line.
  if (std::abs(line.nx * point.nx + line.ny * point.ny) < kSameWall) return nullptr;
  const float off = line.nx * (point.x - line.x) + line.ny * (point.y - line.y);
  return std::abs(off) <= reach ? &line : nullptr;
}

}  // namespace rack::localisation
