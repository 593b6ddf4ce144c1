#include "components/path/free_space.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace rack::path {

namespace {

constexpr float kNowhere = 1e5;  // cells: larger than any map
constexpr double kHalfDiagonals =
    1.4142136;  // cells: maximum offset of a place and an obstacle within their cells

// The intersection of the parabolas over two cells of a line.
double meeting(std::span<const double> line, std::size_t q, std::size_t p) {
  const auto a = static_cast<double>(q);
  const auto b = static_cast<double>(p);
  return ((line[q] + a * a) - (line[p] + b * b)) / (2 * a - 2 * b);
}

}  // namespace

HullDiscs::HullDiscs(const Size& size) : half_width_(size.half_width + size.margin) {
  const double front = size.front + size.margin;
  const double back = size.back + size.margin;
  const double length = std::max(front + back, 1.0);
  // Few discs that exceed the hull only a little.
  const double wanted = std::ceil(length / std::max(half_width_ * 1.2, length / kMax));
  count_ = static_cast<std::size_t>(std::clamp(wanted, 1.0, static_cast<double>(kMax)));
  const double part = length / static_cast<double>(count_);
  for (std::size_t i = 0; i < count_; ++i)
    centers_[i] = -back + part * (static_cast<double>(i) + 0.5);
  radius_ = std::hypot(part / 2, half_width_);
  turning_radius_ = std::hypot(std::max(front, back), half_width_);
}

tims::Result<FreeSpace> FreeSpace::empty(const Place& corner, double width, double height,
                                         double cell) {
  const bool good = std::isfinite(corner.x) && std::isfinite(corner.y) && width > 0 && height > 0 &&
                    cell >= kCellMin;
  if (!good)
    return tims::Error(tims::Errc::kInvalidArgument,
                       "a map needs a size, and cells of 10 mm and more");
  const double rows = std::ceil(width / cell);
  const double columns = std::ceil(height / cell);
  if (!(rows * columns <= static_cast<double>(kCellsMax)))
    return tims::Error(tims::Errc::kTooBig,
                       "a map of " + std::to_string(std::lround(width / 1000)) + " m by " +
                           std::to_string(std::lround(height / 1000)) +
                           " m has more than 4 million cells: use larger cells");
  FreeSpace space;
  space.corner_ = corner;
  space.cell_ = cell;
  space.rows_ = static_cast<std::size_t>(rows);
  space.columns_ = static_cast<std::size_t>(columns);
  space.cells_.assign(space.rows_ * space.columns_, 0);
  space.distances_.assign(space.cells_.size(), 0);
  space.line_.resize(space.columns_);
  space.at_.resize(space.columns_);
  space.begin_.resize(space.columns_ + 1);
  space.squares_.resize(space.columns_);
  space.measure();
  return space;
}

tims::Result<FreeSpace> FreeSpace::of(const GridMapData& map) {
  const auto cells = localisation::read_map(map);
  if (!cells) return cells.error();
  return of(*cells, cells->resolution);
}

tims::Result<FreeSpace> FreeSpace::of(const DxfPlan& plan, double cell, double around) {
  const DxfDrawing& drawing = plan.drawing;
  const PlanPlacement& at = plan.placement;
  if (drawing.lines.empty())
    return tims::Error(tims::Errc::kInvalidArgument, "the drawing has no lines");
  const auto place = [&](const DxfPoint& point) {
    return Place{(point.y - at.offset_x) * at.scale, (point.x - at.offset_y) * at.scale};
  };
  Place least = place(drawing.lines[0].from);
  Place most = least;
  for (const DxfLine& line : drawing.lines) {
    for (const Place& end : {place(line.from), place(line.to)}) {
      least = {std::min(least.x, end.x), std::min(least.y, end.y)};
      most = {std::max(most.x, end.x), std::max(most.y, end.y)};
    }
  }
  const double rim = around + cell;
  auto space = empty({least.x - rim, least.y - rim}, most.x - least.x + 2 * rim,
                     most.y - least.y + 2 * rim, cell);
  if (!space) return space;
  for (const DxfLine& line : drawing.lines) space->occupy(place(line.from), place(line.to));
  space->measure();
  return space;
}

tims::Result<FreeSpace> FreeSpace::of(const localisation::GridMap& map, double cell) {
  auto space = empty({map.origin.x, map.origin.y}, map.rows * map.resolution,
                     map.columns * map.resolution, cell);
  if (!space) return space;
  for (std::int32_t row = 0; row < map.rows; ++row) {
    for (std::int32_t column = 0; column < map.columns; ++column) {
      if (map.at(row, column) != localisation::Cell::kOccupied) continue;
      const Place least{map.origin.x + row * map.resolution,
                        map.origin.y + column * map.resolution};
      space->occupy_area(least, {least.x + map.resolution, least.y + map.resolution});
    }
  }
  space->measure();
  return space;
}

tims::Result<FreeSpace> FreeSpace::of(const localisation::FloorPlan& plan, double cell,
                                      double around) {
  auto space = plan.cells ? of(*plan.cells, cell) : of(plan.drawing, cell, around);
  if (space) return space;
  return tims::Error(space.error().code(), plan.path + ": " + space.error().detail());
}

// --- cells

GridMapData FreeSpace::message() const {
  constexpr u8 kOccupied = 255;
  constexpr std::size_t kMost = decltype(GridMapData::occupancy)::kMax;
  std::size_t factor = 1;
  const auto part = [&](std::size_t count) { return (count + factor - 1) / factor; };
  while (part(rows_) * part(columns_) > kMost) ++factor;
  GridMapData map;
  const double size = cell_ * static_cast<double>(factor);
  map.scale = static_cast<i32>(std::lround(size));
  map.offsetX = whole_millimetres(corner_.x + size / 2);  // the centre of the first cell
  map.offsetY = whole_millimetres(corner_.y + size / 2);
  map.gridNumX = static_cast<i32>(part(rows_));
  map.gridNumY = static_cast<i32>(part(columns_));
  map.occupancy.assign(part(rows_) * part(columns_), 0);
  for (std::size_t row = 0; row < rows_; ++row)
    for (std::size_t column = 0; column < columns_; ++column)
      if (cells_[row * columns_ + column] != 0)
        map.occupancy[row / factor + column / factor * part(rows_)] = kOccupied;  // x runs first
  return map;
}

bool FreeSpace::contains(const Place& place) const {
  const double row = (place.x - corner_.x) / cell_;
  const double column = (place.y - corner_.y) / cell_;
  return row >= 0 && column >= 0 && row < static_cast<double>(rows_) &&
         column < static_cast<double>(columns_);
}

std::size_t FreeSpace::index(const Place& place) const {
  const auto row = static_cast<std::size_t>((place.x - corner_.x) / cell_);
  const auto column = static_cast<std::size_t>((place.y - corner_.y) / cell_);
  return std::min(row, rows_ - 1) * columns_ + std::min(column, columns_ - 1);
}

Place FreeSpace::center_of(std::size_t row, std::size_t column) const {
  return {corner_.x + (static_cast<double>(row) + 0.5) * cell_,
          corner_.y + (static_cast<double>(column) + 0.5) * cell_};
}

void FreeSpace::clear(const Place& corner) {
  corner_ = corner;
  std::fill(cells_.begin(), cells_.end(), std::uint8_t{0});
  measure();
}

void FreeSpace::occupy(const Place& place) {
  if (contains(place)) cells_[index(place)] = 1;
}

void FreeSpace::occupy(const Place& from, const Place& to) {
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  const auto steps = static_cast<std::size_t>(std::ceil(2 * length / cell_)) + 1;
  for (std::size_t i = 0; i <= steps; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(steps);
    occupy({from.x + part * (to.x - from.x), from.y + part * (to.y - from.y)});
  }
}

void FreeSpace::occupy_area(const Place& least, const Place& most) {
  // A border on that of a cell does not touch the cell beyond it, also after rounding.
  constexpr double kBorder = 1e-6;
  const auto index_of = [&](double at, double corner, std::size_t count, double border) {
    const double index = std::floor((at - corner) / cell_ + border);
    return static_cast<std::size_t>(std::clamp(index, 0.0, static_cast<double>(count - 1)));
  };
  const std::size_t last_row = index_of(most.x, corner_.x, rows_, -kBorder);
  const std::size_t last_column = index_of(most.y, corner_.y, columns_, -kBorder);
  for (std::size_t row = index_of(least.x, corner_.x, rows_, kBorder); row <= last_row; ++row)
    for (std::size_t column = index_of(least.y, corner_.y, columns_, kBorder);
         column <= last_column; ++column)
      cells_[row * columns_ + column] = 1;
}

void FreeSpace::release(const Place& place) {
  if (contains(place)) cells_[index(place)] = 0;
}

// Squared distances to the nearest obstacle along line_, from the squared distances across it.
void FreeSpace::envelope() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::size_t last = 0;
  at_[0] = 0;
  begin_[0] = -kInfinity;
  begin_[1] = kInfinity;
  for (std::size_t q = 1; q < columns_; ++q) {
    double meets = meeting(line_, q, at_[last]);
    while (meets <= begin_[last]) meets = meeting(line_, q, at_[--last]);
    at_[++last] = q;
    begin_[last] = meets;
    begin_[last + 1] = kInfinity;
  }
  std::size_t k = 0;
  for (std::size_t q = 0; q < columns_; ++q) {
    while (begin_[k + 1] < static_cast<double>(q)) ++k;
    const double away = static_cast<double>(q) - static_cast<double>(at_[k]);
    squares_[q] = away * away + line_[at_[k]];
  }
}

void FreeSpace::measure() {
  // Distance to the nearest obstacle of the same column, in cells: from below, then from above.
  for (std::size_t i = 0; i < rows_; ++i) {
    for (std::size_t j = 0; j < columns_; ++j) {
      const std::size_t k = i * columns_ + j;
      const float before = i == 0 ? kNowhere : distances_[k - columns_];
      distances_[k] = cells_[k] != 0 ? 0 : before + 1;
    }
  }
  for (std::size_t i = rows_; i-- > 0;) {
    float* row = &distances_[i * columns_];
    for (std::size_t j = 0; j < columns_; ++j) {
      if (i + 1 < rows_) row[j] = std::min(row[j], row[j + columns_] + 1);
    }
  }
  for (std::size_t i = 0; i < rows_; ++i) {
    float* row = &distances_[i * columns_];
    for (std::size_t j = 0; j < columns_; ++j) line_[j] = static_cast<double>(row[j]) * row[j];
    envelope();
    for (std::size_t j = 0; j < columns_; ++j)
      row[j] = static_cast<float>(std::sqrt(squares_[j]) * cell_);
  }
}

// --- queries

bool FreeSpace::occupied(const Place& place) const {
  return !contains(place) || cells_[index(place)] != 0;
}

double FreeSpace::clearance(const Place& place) const {
  if (!contains(place)) return 0;
  const double rim = std::min({place.x - corner_.x, place.y - corner_.y,
                               corner_.x + cell_ * static_cast<double>(rows_) - place.x,
                               corner_.y + cell_ * static_cast<double>(columns_) - place.y});
  const double away = distances_[index(place)] - kHalfDiagonals * cell_;
  return std::max(0.0, std::min(away, rim));
}

double FreeSpace::clearance(const Place& from, const Place& to) const {
  const double length = std::hypot(to.x - from.x, to.y - from.y);
  double least = std::min(clearance(from), clearance(to));
  for (double distance = 0; distance < length && least > 0;) {
    const double part = distance / length;
    const double here =
        clearance({from.x + part * (to.x - from.x), from.y + part * (to.y - from.y)});
    least = std::min(least, here);
    distance += cell_ / 2;
  }
  // Between two samples the obstacle may be nearer by half of their distance.
  return std::max(0.0, least - cell_ / 4);
}

double FreeSpace::room(const HullDiscs& hull, const Pose& at) const {
  const double c = std::cos(at.rho);
  const double s = std::sin(at.rho);
  double least = std::numeric_limits<double>::infinity();
  for (const double ahead : hull.centers())
    least = std::min(least, clearance({at.x + ahead * c, at.y + ahead * s}));
  return least - hull.radius();
}

}  // namespace rack::path
