#include "components/world/core/scenery.h"

#include <algorithm>
#include <cmath>

namespace rack::world {

namespace {

constexpr double kCellMin = 250;      // mm
constexpr double kCellsMax = 400000;  // above, larger cells are used
constexpr double kMargin = 1;         // mm: rounding errors must not lead a ray past a figure

struct Bounds {
  MapPoint low{kNoHit, kNoHit};
  MapPoint high{-kNoHit, -kNoHit};

  void add(const MapPoint& p, double around = 0) {
    low = {std::min(low.x, p.x - around), std::min(low.y, p.y - around)};
    high = {std::max(high.x, p.x + around), std::max(high.y, p.y + around)};
  }
};

double radius_of(const Solid& solid) {
  return solid.shape == Shape::kCircle ? solid.circle.radius : solid.box.radius();
}

// The part of a ray that is in a box along one axis; false: none.
bool clip(double from, double direction, double low, double high, double& first, double& last) {
  if (direction == 0) return from >= low && from <= high;
  const double one = (low - from) / direction;
  const double other = (high - from) / direction;
  first = std::max(first, std::min(one, other));
  last = std::min(last, std::max(one, other));
  return first <= last;
}

}  // namespace

Scenery::Scenery(std::span<const WallDescription> walls,
                 std::span<const ObstacleDescription> obstacles) {
  for (const WallDescription& wall : walls) walls_.push_back({{wall.from, wall.to}, wall.height});
  for (const ObstacleDescription& obstacle : obstacles) solids_.push_back(Solid::of(obstacle));
  make_cells();
  fill();
}

void Scenery::make_cells() {
  Bounds bounds;
  for (const Wall& wall : walls_) {
    bounds.add(wall.segment.from);
    bounds.add(wall.segment.to);
  }
  for (const Solid& solid : solids_) bounds.add(solid.box.at, radius_of(solid));
  if (walls_.empty() && solids_.empty()) return;
  const double around = 2 * kMargin;
  origin_ = {bounds.low.x - around, bounds.low.y - around};
  const double height = bounds.high.x - bounds.low.x + 2 * around;
  const double width = bounds.high.y - bounds.low.y + 2 * around;
  // The grid may be long and narrow: only the number of cells is limited.
  cell_ = std::max(
      {kCellMin, std::sqrt(height * width / kCellsMax), std::max(height, width) / kCellsMax * 4});
  rows_ = static_cast<std::int64_t>(height / cell_) + 1;
  columns_ = static_cast<std::int64_t>(width / cell_) + 1;
}

// Counts first, then writes, so that the lists have their exact size.
void Scenery::fill() {
  begins_.assign(static_cast<std::size_t>(rows_ * columns_) + 1, 0);
  const auto figures = static_cast<Number>(walls_.size() + solids_.size());
  for (Number i = 0; i < figures; ++i) cells_of(i, [&](std::size_t cell) { ++begins_[cell + 1]; });
  for (std::size_t i = 1; i < begins_.size(); ++i) begins_[i] += begins_[i - 1];
  lists_.resize(begins_.back());
  std::vector<std::uint32_t> next(begins_.begin(), begins_.end() - 1);
  for (Number i = 0; i < figures; ++i)
    cells_of(i, [&](std::size_t cell) { lists_[next[cell]++] = i; });
}

template <typename Visit>
void Scenery::cells_of(Number figure, const Visit& visit) const {
  const auto row = [&](std::int64_t x, double low, double high) {
    const auto last = std::min(columns_ - 1, cell_of({0, high + kMargin}).y);
    for (std::int64_t y = std::max<std::int64_t>(0, cell_of({0, low - kMargin}).y); y <= last; ++y)
      visit(static_cast<std::size_t>(x * columns_ + y));
  };
  if (!is_wall(figure)) {
    const MapPoint at = solid(figure).box.at;
    const double reach = radius_of(solid(figure)) + kMargin;
    const std::int64_t last = std::min(rows_ - 1, cell_of({at.x + reach, 0}).x);
    for (std::int64_t x = std::max<std::int64_t>(0, cell_of({at.x - reach, 0}).x); x <= last; ++x)
      row(x, at.y - reach, at.y + reach);
    return;
  }
  // For a wall, only its part in each row of cells.
  const Segment& segment = walls_[figure].segment;
  const auto [low, high] = std::minmax(segment.from.x, segment.to.x);
  const std::int64_t last = std::min(rows_ - 1, cell_of({high + kMargin, 0}).x);
  const double length = segment.to.x - segment.from.x;
  const auto at = [&](double x) {
    const double part = std::clamp((x - segment.from.x) / length, 0.0, 1.0);
    return segment.from.y + part * (segment.to.y - segment.from.y);
  };
  for (std::int64_t x = std::max<std::int64_t>(0, cell_of({low - kMargin, 0}).x); x <= last; ++x) {
    const double begin = origin_.x + static_cast<double>(x) * cell_ - kMargin;
    double one = segment.from.y;
    double other = segment.to.y;
    if (high - low > kMargin) {
      one = at(begin);
      other = at(begin + cell_ + 2 * kMargin);
    }
    row(x, std::min(one, other), std::max(one, other));
  }
}

Scenery::Cell Scenery::cell_of(const MapPoint& at) const {
  return {static_cast<std::int64_t>(std::floor((at.x - origin_.x) / cell_)),
          static_cast<std::int64_t>(std::floor((at.y - origin_.y) / cell_))};
}

std::span<const Scenery::Number> Scenery::at(const Cell& cell) const {
  const auto index = static_cast<std::size_t>(cell.x * columns_ + cell.y);
  return std::span(lists_).subspan(begins_[index], begins_[index + 1] - begins_[index]);
}

void Scenery::try_cell(const Ray& ray, const Cell& cell, Hit& best) const {
  for (const Number figure : at(cell)) {
    const double range = is_wall(figure) ? meets(ray, walls_[figure].segment, walls_[figure].height)
                                         : meets(ray, solid(figure));
    if (range < best.range) best = {range, is_wall(figure) ? Met::kWall : Met::kObstacle};
  }
}

Scenery::Hit Scenery::cast(const Ray& ray) const {
  Hit best;
  double first = 0;
  double last = ray.reach;
  if (rows_ == 0 ||
      !clip(ray.from.x, ray.x, origin_.x, origin_.x + static_cast<double>(rows_) * cell_, first,
            last) ||
      !clip(ray.from.y, ray.y, origin_.y, origin_.y + static_cast<double>(columns_) * cell_, first,
            last))
    return best;
  Cell cell = cell_of({ray.from.x + first * ray.x, ray.from.y + first * ray.y});
  cell = {std::clamp<std::int64_t>(cell.x, 0, rows_ - 1),
          std::clamp<std::int64_t>(cell.y, 0, columns_ - 1)};
  const std::int64_t step_x = ray.x < 0 ? -1 : 1;
  const std::int64_t step_y = ray.y < 0 ? -1 : 1;
  // Distances to the next borders between cells.
  const auto border = [&](std::int64_t index, std::int64_t step, double origin, double from,
                          double direction) {
    if (direction == 0) return kNoHit;
    const double at = origin + static_cast<double>(index + (step > 0 ? 1 : 0)) * cell_;
    return (at - from) / direction;
  };
  double next_x = border(cell.x, step_x, origin_.x, ray.from.x, ray.x);
  double next_y = border(cell.y, step_y, origin_.y, ray.from.y, ray.y);
  const double each_x = ray.x == 0 ? kNoHit : cell_ / std::abs(ray.x);
  const double each_y = ray.y == 0 ? kNoHit : cell_ / std::abs(ray.y);
  for (;;) {
    try_cell(ray, cell, best);
    const double leaves = std::min(next_x, next_y);
    if (best.range <= leaves || leaves >= last) break;
    if (next_x < next_y) {
      cell.x += step_x;
      next_x += each_x;
      if (cell.x < 0 || cell.x >= rows_) break;
    } else {
      cell.y += step_y;
      next_y += each_y;
      if (cell.y < 0 || cell.y >= columns_) break;
    }
  }
  return best.range <= ray.reach ? best : Hit{};
}

template <typename Visit>
void Scenery::near(const MapPoint& middle, double reach, const Visit& visit) const {
  if (rows_ == 0) return;
  const Cell low = cell_of({middle.x - reach, middle.y - reach});
  const Cell high = cell_of({middle.x + reach, middle.y + reach});
  for (std::int64_t x = std::max<std::int64_t>(0, low.x); x <= std::min(high.x, rows_ - 1); ++x)
    for (std::int64_t y = std::max<std::int64_t>(0, low.y); y <= std::min(high.y, columns_ - 1);
         ++y)
      for (const Number figure : at({x, y})) visit(figure);
}

double Scenery::clearance(const MapPoint& at, double most) const {
  double nearest = most;
  near(at, most, [&](Number figure) {
    nearest = std::min(nearest, is_wall(figure) ? distance(at, walls_[figure].segment)
                                                : distance(at, solid(figure)));
  });
  return nearest;
}

Met Scenery::touches(const Box& box) const {
  Met met = Met::kNothing;
  near(box.at, box.radius(), [&](Number figure) {
    if (met == Met::kWall) return;
    if (is_wall(figure)) {
      if (overlap(box, walls_[figure].segment)) met = Met::kWall;
    } else if (overlap(box, solid(figure))) {
      met = Met::kObstacle;
    }
  });
  return met;
}

}  // namespace rack::world
