// A floor plan: the walls of a drawing, and rays that are cast against them (specification, section
// 10.3). Pure.
//
// A scanner is a fan of rays from one point. For each wall, only the rays between the directions of
// its ends are intersected with its line, and the range becomes the minimum. The cost is the number
// of walls times the rays that hit them, instead of all pairs.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "components/geometry/dxf.h"

namespace rack {

struct MapPoint {
  double x = 0;  // mm to the north
  double y = 0;  // mm to the east
};

inline double distance(const MapPoint& a, const MapPoint& b) {
  return std::hypot(a.x - b.x, a.y - b.y);
}

// Rays from one point: angles first, first + step, ...
struct RayFan {
  MapPoint from{};
  double first = 0;  // rad, clockwise from north
  double step = 0;   // rad, more than 0
};

class FloorMap {
 public:
  FloorMap() = default;
  // A drawing has x to the east and y to the north; robots have x to the north and y to the east. x
  // = (drawing's y - offset_x) * scale, y = (drawing's x - offset_y) * scale.
  FloorMap(const DxfDrawing& drawing, double scale, double offset_x, double offset_y);
  explicit FloorMap(const DxfPlan& plan)
      : FloorMap(plan.drawing, plan.placement.scale, plan.placement.offset_x,
                 plan.placement.offset_y) {}

  struct Wall {
    MapPoint from;
    MapPoint extent;  // vector from `from` to its end
    double length;
  };
  [[nodiscard]] std::span<const Wall> walls() const { return walls_; }
  [[nodiscard]] std::size_t size() const { return walls_.size(); }

  // The distance to the nearest wall along each ray, at most max_range.
  void cast(const RayFan& fan, double max_range, std::span<double> ranges) const;
  // The distance to the nearest wall in any direction.
  [[nodiscard]] double clearance(const MapPoint& at) const;

 private:
  static void cast(const Wall& wall, const RayFan& fan, std::span<double> ranges);
  static double range(const Wall& wall, const MapPoint& from, double angle, double otherwise);

  std::vector<Wall> walls_;
};

}  // namespace rack
