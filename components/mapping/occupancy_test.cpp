// Walls drawn from beams whose ranges err.
#include "components/mapping/occupancy.h"

#include <cmath>

#include <gtest/gtest.h>

#include "components/geometry/random.h"

namespace rack::mapping {

namespace occupancy_test {

using localisation::Cell;
using localisation::GridMap;

constexpr double kCell = 50;  // mm

struct Thickness {
  double cells = 0;  // occupied, of a row across the wall
  double off = 0;    // mm: their middle beside the wall, away from the robot
};

// A wall along y at x = `wall`, seen from several places in front of it, or from both sides.
Thickness drawn(double wall, double noise, bool both_sides) {
  auto occupancy = Occupancy::of(kCell, {-4000, -3000}, {8000, 3000});
  EXPECT_TRUE(occupancy.ok());
  Random random(1);
  for (const double side : {-1.0, 1.0}) {
    if (side > 0 && !both_sides) continue;
    for (double y = -2000; y <= 2000; y += 200)
      for (double angle = -1.2; angle <= 1.2; angle += kPi / 360) {
        const double range = 1500 / std::cos(angle) + noise * static_cast<double>(random.normal());
        const MapPoint from{wall + side * 1500, y};
        occupancy->add_beam(
            from, {from.x - side * range * std::cos(angle), from.y + range * std::sin(angle)});
      }
  }
  const GridMap map = occupancy->map();
  Thickness found;
  int columns = 0;
  for (std::int32_t column = 40; column < 80; ++column, ++columns)
    for (std::int32_t row = 0; row < map.rows; ++row) {
      if (map.at(row, column) != Cell::kOccupied) continue;
      found.cells += 1;
      found.off += map.origin.x + (row + 0.5) * kCell - wall;
    }
  return {found.cells / columns, found.off / found.cells};
}

TEST(Occupancy, AWallIsNotACellThickerAwayFromTheRobot) {
  for (const double noise : {0.0, 10.0, 20.0}) {
    const Thickness middle = drawn(2025, noise, false);
    EXPECT_NEAR(middle.cells, 1, 0.3) << noise;
    EXPECT_NEAR(middle.off, 0, 8) << noise;
  }
}

TEST(Occupancy, AThinWallSeenFromBothSidesStaysThere) {
  for (const double wall : {2005.0, 2025.0, 2045.0}) {
    const Thickness both = drawn(wall, 15, true);
    EXPECT_GE(both.cells, 1) << wall;
    EXPECT_LE(both.cells, 2.2) << wall;
    EXPECT_NEAR(both.off, 0, 26) << wall;
  }
}

TEST(Occupancy, RefusesWhatHasNoSizeOrTooMuch) {
  EXPECT_FALSE(Occupancy::of(kCell, {0, 0}, {1e9, 1e9}).ok());
  EXPECT_FALSE(Occupancy::of(kCell, {0, 0}, {-1000, 0}).ok());
}

}  // namespace occupancy_test

}  // namespace rack::mapping
