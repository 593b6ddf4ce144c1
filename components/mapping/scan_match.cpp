#include "components/mapping/scan_match.h"

#include <algorithm>
#include <cmath>

namespace rack::mapping {

namespace {

constexpr std::int64_t kScanMatchCellsMax = 4'000'000;
constexpr float kSameWall = 0.7F;  // cosine of the angle between normals

}  // namespace

std::vector<ScanPoint2d> points_of(std::span<const BeamEnd> scan, const Pose& scanner) {
  std::vector<ScanPoint2d> points;
  localisation::points_of(scan, scanner, 1, points);
  return points;
}

void add_points(std::span<const ScanPoint2d> points, const Pose& frame,
                std::vector<ScanPoint2d>& to) {
  const auto c = static_cast<float>(std::cos(frame.rho));
  const auto s = static_cast<float>(std::sin(frame.rho));
  const auto x = static_cast<float>(frame.x);
  const auto y = static_cast<float>(frame.y);
  for (const ScanPoint2d& p : points)
    to.push_back(
        {x + c * p.x - s * p.y, y + s * p.x + c * p.y, c * p.nx - s * p.ny, s * p.nx + c * p.ny});
}

// Counting sort by cells. Points that are not on a wall are left out.
PointIndex::PointIndex(std::span<const ScanPoint2d> points) {
  float high_x = -1e9F;
  float high_y = -1e9F;
  low_x_ = low_y_ = 1e9F;
  for (const ScanPoint2d& p : points) {
    if (!p.on_wall()) continue;
    low_x_ = std::min(low_x_, p.x);
    low_y_ = std::min(low_y_, p.y);
    high_x = std::max(high_x, p.x);
    high_y = std::max(high_y, p.y);
  }
  if (high_x < low_x_) return;
  const double rows = std::floor(static_cast<double>(high_x - low_x_) / kReach) + 3;
  const double columns = std::floor(static_cast<double>(high_y - low_y_) / kReach) + 3;
  if (!(rows * columns < kScanMatchCellsMax)) return;
  low_x_ -= kReach;  // a row around, so that each cell has neighbours
  low_y_ -= kReach;
  rows_ = static_cast<std::int32_t>(rows);
  columns_ = static_cast<std::int32_t>(columns);
  begin_.resize(static_cast<std::size_t>(rows_) * static_cast<std::size_t>(columns_) + 1);
  std::size_t count = 0;
  for (const ScanPoint2d& p : points) {
    if (!p.on_wall()) continue;
    ++begin_[cell(p.x, p.y) + 1];
    ++count;
  }
  for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  points_.resize(count);
  for (const ScanPoint2d& p : points)
    if (p.on_wall()) points_[next[cell(p.x, p.y)]++] = p;
}

std::size_t PointIndex::cell(float x, float y) const {
  const auto row = static_cast<std::size_t>((x - low_x_) / kReach);
  const auto column = static_cast<std::size_t>((y - low_y_) / kReach);
  return row * static_cast<std::size_t>(columns_) + column;
}

const ScanPoint2d* PointIndex::nearest(const ScanPoint2d& point, float reach) const {
  const float row = (point.x - low_x_) / kReach;
  const float column = (point.y - low_y_) / kReach;
  // Also false when a coordinate is not a number.
  const bool is_inside = row >= 1 && column >= 1 && row < static_cast<float>(rows_ - 1) &&
                         column < static_cast<float>(columns_ - 1);
  if (!is_inside) return nullptr;
  const auto middle = static_cast<std::ptrdiff_t>(cell(point.x, point.y));
  float least = reach * reach;
  const ScanPoint2d* best = nullptr;
  for (std::ptrdiff_t r = -columns_; r <= columns_; r += columns_) {
    // The points of three neighbouring cells of a row are contiguous.
    const std::uint32_t end = begin_[static_cast<std::size_t>(middle + r + 2)];
    for (std::uint32_t i = begin_[static_cast<std::size_t>(middle + r - 1)]; i < end; ++i) {
      const ScanPoint2d& other = points_[i];
      const float dx = other.x - point.x;
      const float dy = other.y - point.y;
      const float square = dx * dx + dy * dy;
      if (square >= least) continue;
      if (other.nx * point.nx + other.ny * point.ny < kSameWall) continue;
      least = square;
      best = &other;
    }
  }
  return best;
}

}  // namespace rack::mapping
