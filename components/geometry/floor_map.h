// A floor plan: reads walls from a DXF file, and casts rays against them (specification, section
// 10.3). Pure.
//
// DXF is a sequence of line pairs, a group code and its value; an entity begins with code 0 and its
// name. Lines and polylines are walls, other entities are ignored, and damaged ones are skipped and
// reported with their line number. A scanner is a fan of rays from one point. For each wall, only
// the rays between the directions of its ends are intersected with its line, and the range becomes
// the minimum. The cost is the number of walls times the rays that hit them, instead of all pairs.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tims/result.h"

namespace rack {

// --- A drawing: LINE, POLYLINE with its VERTEXes, LWPOLYLINE and POINT of the section ENTITIES
// (or of a file without sections); curves in polylines become straight.

struct DxfPoint {
  double x = 0;  // to the east, in units of the drawing
  double y = 0;  // to the north
};

struct DxfLine {
  DxfPoint from;
  DxfPoint to;
  std::int32_t layer = 0;  // number in its name
};

struct DxfDrawing {
  std::vector<DxfLine> lines;
  std::vector<std::string> skipped;  // "line 17: LINE without an end", at most kSkippedMax
  std::size_t others = 0;            // entities of other types

  static constexpr std::size_t kLinesMax = 20000;
  static constexpr std::size_t kSkippedMax = 20;
};

// The error kMalformed names the line where the text is not DXF.
tims::Result<DxfDrawing> read_dxf(std::string_view text);

// --- Walls in the plane, and distances to them.

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
