// A spatial index of scan points, for matching other scans against them
// (`components/localisation/line_match.h`). Pure.
//
// The two sides of a thin wall are two walls: only points with a similar normal are matched. Points
// are sorted into cells as large as the maximum reach, so that a look-up visits nine cells.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "components/localisation/line_match.h"

namespace rack::mapping {

using localisation::BeamEnd;
using localisation::Information;
using localisation::match;
using localisation::Match;
using localisation::Prior;
using localisation::ScanPoint2d;

// Thinned to one point per 40 mm.
std::vector<ScanPoint2d> points_of(std::span<const BeamEnd> scan, const Pose& scanner);
// Appends the points, transformed by `frame`.
void add_points(std::span<const ScanPoint2d> points, const Pose& frame,
                std::vector<ScanPoint2d>& to);

// Points sorted by cells.
class PointIndex final : public localisation::Lines {
 public:
  explicit PointIndex(std::span<const ScanPoint2d> points);

  [[nodiscard]] bool empty() const override { return points_.empty(); }
  // The nearest point within `reach` (at most kReach) whose normal is similar to that of `point`;
  // nullptr: none.
  [[nodiscard]] const ScanPoint2d* nearest(const ScanPoint2d& point, float reach) const override;

  static constexpr float kReach = 300;  // mm

 private:
  [[nodiscard]] std::size_t cell(float x, float y) const;

  float low_x_ = 0;
  float low_y_ = 0;
  std::int32_t rows_ = 0;
  std::int32_t columns_ = 0;
  std::vector<std::uint32_t> begin_;  // index of the first point of each cell
  std::vector<ScanPoint2d> points_;
};

}  // namespace rack::mapping
