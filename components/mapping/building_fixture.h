// For tests: a building with a corridor around its core, a robot with erroneous odometry, and a
// scanner with 180 degrees.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "components/geometry/floor_map.h"
#include "components/geometry/random.h"
#include "components/mapping/drive.h"

namespace rack::mapping::test {

inline DxfDrawing building() {
  DxfDrawing drawing;
  const auto wall = [&](double x, double y, double x2, double y2) {
    drawing.lines.push_back({{x, y}, {x2, y2}});
  };
  const auto box = [&](double x, double y, double x2, double y2) {
    wall(x, y, x2, y);
    wall(x2, y, x2, y2);
    wall(x2, y2, x, y2);
    wall(x, y2, x, y);
  };
  box(0, 0, 16, 12);         // the house
  box(2.5, 2.5, 13.5, 9.5);  // its core, surrounded by the corridor
  box(4, 0, 4.4, 0.5);       // pillars, no two alike
  box(9, 0, 9.2, 0.9);
  box(15.3, 4, 16, 4.5);
  box(15.6, 7, 16, 7.3);
  box(11, 11.4, 12, 12);
  box(6, 11.7, 6.2, 12);
  box(0, 8, 0.6, 8.3);
  box(0, 3.5, 0.3, 4.6);
  return drawing;
}

class Building {
 public:
  explicit Building(std::uint64_t seed) : rays_(building(), 1000, 0, 0), random_(seed) {}

  // The pose after `distance` mm along the middle of the corridor, corners rounded.
  static Pose place(double distance) {
    constexpr double kX = 4750;  // half of it, to the north
    constexpr double kY = 6750;
    constexpr double kRadius = 800;
    constexpr double kLength = 4 * (kX + kY - 2 * kRadius) + 2 * kPi * kRadius;
    double left = std::fmod(distance, kLength);
    Pose at{.x = 6000 - kX, .y = 8000 - kY + kRadius, .rho = kPi / 2};
    for (const double side : {kY, kX, kY, kX}) {
      const double straight = 2 * (side - kRadius);
      if (left <= straight) return at + Pose{.x = left};
      at = at + Pose{.x = straight};
      left -= straight;
      const double part = std::min(left / kRadius, kPi / 2);
      at = at +
           Pose{.x = kRadius * std::sin(part), .y = -kRadius * (1 - std::cos(part)), .rho = -part};
      left -= kRadius * kPi / 2;
      if (left <= 0) return at;
    }
    return at;
  }

  // `drift`: heading error of the odometry, rad per metre.
  Drive drive(double distance, double step, double drift) {
    Drive drive;
    truth_.clear();
    Pose odometry{.x = 1000, .y = -2000, .rho = 0.3};
    for (double at = 0; at <= distance; at += step) {
      const Pose now = place(at);
      if (!truth_.empty()) {
        Pose went = now - truth_.back();
        went.x *= 1 + 0.03 * normal();
        went.rho += drift * step / 1000 + 0.002 * normal();
        odometry = odometry + went;
      }
      truth_.push_back(now);
      add_scan(drive, now, odometry, at / 500);
    }
    return drive;
  }
  [[nodiscard]] const std::vector<Pose>& truth() const { return truth_; }

  void add_scan(Drive& drive, const Pose& from, const Pose& odometry, double time) {
    std::array<double, 181> ranges{};
    rays_.cast({{from.x, from.y}, from.rho - kPi / 2, kPi / 180}, 30000, ranges);
    const std::size_t begin = drive.ends.size();
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      const double range = ranges[i] + 10 * normal();
      const double angle = -kPi / 2 + static_cast<double>(i) * kPi / 180;
      if (ranges[i] < 29000)
        drive.ends.push_back({static_cast<float>(range * std::cos(angle)),
                              static_cast<float>(range * std::sin(angle))});
    }
    drive.scans.push_back({.time = time,
                           .odometry = odometry,
                           .row = drive.scans.size(),
                           .begin = begin,
                           .count = drive.ends.size() - begin});
  }

 private:
  double normal() { return static_cast<double>(random_.normal()); }

  FloorMap rays_;
  Random random_;
  std::vector<Pose> truth_;
};

}  // namespace rack::mapping::test
