// Walls seen from above, and how far it is to them (specification, section 10.3). Pure.
#pragma once

#include <span>
#include <vector>

#include "components/geometry/dxf.h"

namespace rack {

struct MapPoint {
  double x = 0;  // mm to the north
  double y = 0;  // mm to the east
};

// Rays from one point: angles first, first + step, ...
struct Fan {
  MapPoint from{};
  double first = 0;  // rad, clockwise from north
  double step = 0;   // rad, more than 0
};

class FloorMap {
 public:
  FloorMap() = default;
  // A drawing has x to the east and y to the north; robots have x to the north and y to the east.
  // x = (drawing's y - offset_x) * scale, y = (drawing's x - offset_y) * scale.
  FloorMap(const DxfDrawing& drawing, double scale, double offset_x, double offset_y);

  [[nodiscard]] std::size_t size() const { return walls_.size(); }

  // The way to the nearest wall along each ray, at most max_range.
  void cast(const Fan& fan, double max_range, std::span<double> ranges) const;
  // How far the nearest wall is, in any direction.
  [[nodiscard]] double clearance(const MapPoint& at) const;

 private:
  struct Wall {
    MapPoint from;
    MapPoint way;  // to its end
    double length;
  };
  static void cast(const Wall& wall, const Fan& fan, std::span<double> ranges);
  static double range(const Wall& wall, const MapPoint& from, double angle, double otherwise);

  std::vector<Wall> walls_;
};

}  // namespace rack
