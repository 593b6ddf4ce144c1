// The walls of plans and of cells as lines: their position and direction, and which cells have
// none.
#include "components/localisation/wall_lines.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "components/geometry/random.h"

namespace rack::localisation {

namespace wall_lines_test {

// A wall through the middle of a room, turned and not on the border of cells.
MapLine wall_at(double turned) {
  return {{5013 - 2000 * std::cos(turned), 5007 - 2000 * std::sin(turned)},
          {5013 + 2000 * std::cos(turned), 5007 + 2000 * std::sin(turned)}};
}
GridMap map_with(const MapLine& wall, bool as_cells) {
  const std::vector<MapLine> walls{{{0, 0}, {10000, 0}},
                                   {{10000, 0}, {10000, 10000}},
                                   {{10000, 10000}, {0, 10000}},
                                   {{0, 10000}, {0, 0}},
                                   wall};
  auto map = draw_walls(walls, 50);
  EXPECT_TRUE(map.ok());
  if (as_cells) map->walls.clear();
  return std::move(map).value();
}

// For points along the wall and beside it: the error of their lines.
TEST(WallLines, SayHowFarAPointIsFromItsWall) {
  for (const bool as_cells : {false, true})
    for (double turned = 0; turned < 3.1; turned += 0.13) {
      const WallLines lines(map_with(wall_at(turned), as_cells));
      const auto nx = static_cast<float>(-std::sin(turned));
      const auto ny = static_cast<float>(std::cos(turned));
      double sum = 0;
      double squares = 0;
      int count = 0;
      for (double along = -1600; along <= 1600; along += 23)
        for (const double beside : {-90.0, -30.0, 0.0, 45.0, 80.0}) {
          const ScanPoint2d point{
              static_cast<float>(5013 + along * std::cos(turned)) + nx * static_cast<float>(beside),
              static_cast<float>(5007 + along * std::sin(turned)) + ny * static_cast<float>(beside),
              nx, ny};
          const ScanPoint2d* line = lines.nearest(point, 300);
          if (line == nullptr) continue;
          const float sign = line->nx * nx + line->ny * ny > 0 ? 1.0F : -1.0F;
          const float off =
              sign * (line->nx * (point.x - line->x) + line->ny * (point.y - line->y));
          sum += static_cast<double>(off) - beside;
          squares += (static_cast<double>(off) - beside) * (static_cast<double>(off) - beside);
          ++count;
        }
      ASSERT_GT(count, 600) << turned << " " << as_cells;
      // Cells are drawn where the wall passes; walls as cells are a fifth of a cell beside.
      EXPECT_NEAR(sum / count, 0, as_cells ? 12 : 0.5) << turned << " " << as_cells;
      EXPECT_LT(std::sqrt(squares / count), as_cells ? 16 : 1) << turned << " " << as_cells;
    }
}

TEST(WallLines, PointsWithAnotherDirectionOrFarAwayBelongToAnotherWall) {
  const WallLines lines(map_with(wall_at(0), false));
  const float x = 5013;
  EXPECT_NE(lines.nearest({x, 5007, 0, 1}, 300), nullptr);
  EXPECT_NE(lines.nearest({x, 5007, 0, -1}, 300), nullptr) << "from its other side";
  EXPECT_EQ(lines.nearest({x, 5007, 1, 0}, 300), nullptr);
  EXPECT_EQ(lines.nearest({x, 5207, 0, 1}, 100), nullptr);
  EXPECT_EQ(lines.nearest({x, 6500, 0, 1}, 300), nullptr);
}

TEST(WallLines, WhatIsNoWallAndNoPlace) {
  GridMap map{.rows = 100, .columns = 100};
  map.cells.assign(10000, Cell::kFree);
  EXPECT_TRUE(WallLines(map).empty());
  EXPECT_TRUE(WallLines(GridMap{}).empty());
  EXPECT_EQ(WallLines().nearest({0, 0, 1, 0}, 300), nullptr);
  // Bushes.
  Random random(1);
  for (Cell& cell : map.cells)
    if (random.below(3) == 0) cell = Cell::kOccupied;
  EXPECT_LT(WallLines(map).size(), map.count(Cell::kOccupied) / 3);
  // A wall as thick as a house has its surfaces.
  for (std::size_t i = 0; i < 10000; ++i) map.cells[i] = i < 3000 ? Cell::kOccupied : Cell::kFree;
  const WallLines thick(map);
  EXPECT_NE(thick.nearest({1500, 2500, 1, 0}, 300), nullptr);
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kEndless = std::numeric_limits<float>::infinity();
  for (const float far : {kNan, kEndless, -kEndless, 1e30F, -1.0F, 5000.0F})
    for (const ScanPoint2d& point :
         {ScanPoint2d{far, 2500, 1, 0}, ScanPoint2d{2500, far, 1, 0}, ScanPoint2d{far, far, 1, 0}})
      EXPECT_EQ(thick.nearest(point, 300), nullptr) << far;
  GridMap points = map_with(wall_at(0), false);
  for (MapLine& wall : points.walls) wall.to = wall.from;
  EXPECT_TRUE(WallLines(points).empty()) << "walls without length";
}

}  // namespace wall_lines_test

}  // namespace rack::localisation
