// Points of scans by where they are, so that other scans can be laid on them
// (`components/localisation/line_match.h` lays them). Pure.
//
// The two sides of a thin wall are two walls: a point is given the nearest of the points whose wall
// looks the same way as its own. Points are sorted into cells as large as the farthest that is
// asked for, so that nine cells are looked at.
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

// Not more than a point each 40 mm.
std::vector<ScanPoint2d> points_of(std::span<const BeamEnd> scan, const Pose& scanner);
// Seen from `frame`.
void add_points(std::span<const ScanPoint2d> points, const Pose& frame,
                std::vector<ScanPoint2d>& to);

// Points by where they are.
class PointIndex final : public localisation::Lines {
 public:
  explicit PointIndex(std::span<const ScanPoint2d> points);

  [[nodiscard]] bool empty() const override { return points_.empty(); }
  // The nearest one within kReach whose wall looks like that of `point`; nullptr: none.
  [[nodiscard]] const ScanPoint2d* nearest(const ScanPoint2d& point, float reach) const override;

  static constexpr float kReach = 300;  // mm

 private:
  [[nodiscard]] std::size_t cell(float x, float y) const;

  float low_x_ = 0;
  float low_y_ = 0;
  std::int32_t rows_ = 0;
  std::int32_t columns_ = 0;
  std::vector<std::uint32_t> begin_;  // by cell: its first point
  std::vector<ScanPoint2d> points_;
};

}  // namespace rack::mapping
