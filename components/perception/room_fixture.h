// For tests: the scan of an empty room of 12 m x 12 m with round objects.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "components/geometry/random.h"
#include "components/perception/free_table.h"

namespace rack::perception {

inline DxfDrawing room() {
  DxfDrawing drawing;
  drawing.lines = {{{-6, -6}, {6, -6}}, {{6, -6}, {6, 6}}, {{6, 6}, {-6, 6}}, {{-6, 6}, {-6, -6}}};
  return drawing;
}

// The robot is at the origin by default; beams every half degree, 360 degrees.
class Room {
 public:
  explicit Room(std::uint64_t seed = 1) : walls_(room(), 1000, 0, 0), random_(seed) {}

  struct Circle {
    MapPoint at{};
    double radius = 60;
  };
  Scan2dData scan(const std::vector<Circle>& circles, const Pose& robot = {}) {
    Scan2dData scan{.recordingTime = time, .maxRange = 20000};
    std::array<double, 720> ranges{};
    walls_.cast({.from = {robot.x, robot.y}, .first = robot.rho - kPi, .step = radians(0.5)}, 20000,
                ranges);
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const double local = -kPi + radians(0.5) * static_cast<double>(i);
      for (const Circle& circle : circles) {
        const double dx = circle.at.x - robot.x;
        const double dy = circle.at.y - robot.y;
        const double along = dx * std::cos(local + robot.rho) + dy * std::sin(local + robot.rho);
        const double beside = dx * dx + dy * dy - along * along;
        const double r2 = circle.radius * circle.radius;
        if (along > 0 && beside < r2)
          ranges[i] = std::min(ranges[i], along - std::sqrt(r2 - beside));
      }
      const double range = ranges[i] + 10 * static_cast<double>(random_.normal());
      scan.points.push_back({.x = whole_millimetres(range * std::cos(local)),
                             .y = whole_millimetres(range * std::sin(local)),
                             .z = whole_millimetres(range)});
    }
    return scan;
  }
  static std::vector<Circle> person(double x, double y) { return {{{x, y - 120}}, {{x, y + 120}}}; }

  u32 time = 1000;

 private:
  FloorMap walls_;
  Random random_;
};

// The free space of a scan.
inline FreeTable table_of(const Scan2dData& scan, const Pose& robot = {}) {
  ScanView view;
  view.take(scan, {}, 30000);
  view.place(robot);
  FreeTable table;
  table.fill(view);
  return table;
}

}  // namespace rack::perception
