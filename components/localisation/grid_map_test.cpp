#include "components/localisation/grid_map.h"

#include <limits>

#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack::localisation {

namespace grid_map_test {

// A room of 4 m x 2 m.
std::vector<MapLine> room() {
  return {{{0, 0}, {4000, 0}},
          {{4000, 0}, {4000, 2000}},
          {{4000, 2000}, {0, 2000}},
          {{0, 2000}, {0, 0}}};
}

Cell cell_at(const GridMap& map, double x, double y) {
  return map.at(static_cast<std::int32_t>((x - map.origin.x) / map.resolution),
                static_cast<std::int32_t>((y - map.origin.y) / map.resolution));
}

TEST(GridMap, WallsAreDrawnAndTheirInsideIsFree) {
  const auto map = draw_walls(room(), 50);
  ASSERT_TRUE(map.ok());
  for (double x = 0; x <= 4000; x += 10) {
    EXPECT_EQ(cell_at(*map, x, 0), Cell::kOccupied) << x;
    EXPECT_EQ(cell_at(*map, x, 2000), Cell::kOccupied) << x;
  }
  EXPECT_EQ(cell_at(*map, 2000, 1000), Cell::kFree);
  EXPECT_EQ(cell_at(*map, -300, 1000), Cell::kUnknown);
  EXPECT_EQ(cell_at(*map, 2000, 2300), Cell::kUnknown);
}

TEST(GridMap, WallsOfRoundNumbersLieInTheMiddleOfTheirCells) {
  const auto map = draw_walls(room(), 50);
  ASSERT_TRUE(map.ok());
  for (const double beside : {-20.0, 20.0}) {
    EXPECT_EQ(cell_at(*map, 1000, beside), Cell::kOccupied) << beside;
    EXPECT_EQ(cell_at(*map, 4000 + beside, 1000), Cell::kOccupied) << beside;
  }
  EXPECT_NE(cell_at(*map, 1000, -30), Cell::kOccupied);
  EXPECT_NE(cell_at(*map, 1000, 30), Cell::kOccupied);
  EXPECT_EQ(map->walls.size(), 4U);
}

TEST(GridMap, BetweenOpenWallsAllIsFree) {
  const std::vector<MapLine> walls{{{0, 0}, {4000, 0}}, {{0, 2000}, {4000, 2000}}};
  const auto map = draw_walls(walls, 50);
  ASSERT_TRUE(map.ok());
  EXPECT_EQ(map->count(Cell::kUnknown), 0U);
  EXPECT_EQ(cell_at(*map, 2000, 1000), Cell::kFree);
}

TEST(GridMap, ADiagonalWallHasNoHoles) {
  auto walls = room();
  walls.push_back({{0, 0}, {4000, 2000}});
  const auto map = draw_walls(walls, 50);
  ASSERT_TRUE(map.ok());
  for (double part = 0; part <= 1; part += 0.001)
    EXPECT_EQ(cell_at(*map, 4000 * part, 2000 * part), Cell::kOccupied) << part;
}

TEST(GridMap, RefusesWhatIsNoMap) {
  EXPECT_FALSE(draw_walls({}, 50).ok());
  EXPECT_FALSE(draw_walls(room(), 0).ok());
  EXPECT_FALSE(draw_walls(room(), std::numeric_limits<double>::quiet_NaN()).ok());
  auto walls = room();
  walls.push_back({{0, 0}, {std::numeric_limits<double>::infinity(), 0}});
  EXPECT_FALSE(draw_walls(walls, 50).ok());
  walls.back().to.x = 1e9;
  const auto map = draw_walls(walls, 50);
  ASSERT_FALSE(map.ok());
  EXPECT_NE(map.error().detail().find("larger cells"), std::string::npos);
}

TEST(GridMap, OfAFloorPlanLiesAsItsRays) {
  DxfDrawing drawing;
  drawing.lines.push_back({{1, 2}, {1, 6}});  // east of 1, from north 2 to 6
  drawing.lines.push_back({{3, 2}, {3, 6}});
  const auto map = read_map(drawing, 1000, 0, 0, 50);
  ASSERT_TRUE(map.ok());
  EXPECT_EQ(cell_at(*map, 4000, 1000), Cell::kOccupied);
  EXPECT_EQ(cell_at(*map, 4000, 2000), Cell::kFree);
  const FloorMap rays(drawing, 1000, 0, 0);
  EXPECT_DOUBLE_EQ(rays.clearance({4000, 1000}), 0);
}

TEST(GridMap, OfFeatures) {
  FeatureMapData features;
  for (const MapLine& wall : room())
    features.features.push_back(
        {.x = wall.from.x, .y = wall.from.y, .x2 = wall.to.x, .y2 = wall.to.y});
  features.features.push_back({.x = 2000, .y = 1000, .x2 = 2000, .y2 = 1000, .type = 1});
  const auto map = read_map(features, 50);
  ASSERT_TRUE(map.ok());
  EXPECT_EQ(cell_at(*map, 2000, 1000), Cell::kFree) << "no line";
  EXPECT_EQ(cell_at(*map, 4000, 1000), Cell::kOccupied);
}

TEST(GridMap, ThroughAMessageAndBack) {
  const auto map = draw_walls(room(), 50);
  ASSERT_TRUE(map.ok());
  GridMapData message;
  to_message(*map, {0, 0, map->rows, map->columns}, message);
  EXPECT_EQ(message.gridNumX, map->rows);
  const auto back = read_map(message);
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->cells, map->cells);
  EXPECT_DOUBLE_EQ(back->origin.x, map->origin.x);
  EXPECT_DOUBLE_EQ(back->origin.y, map->origin.y);
}

TEST(GridMap, CoarserButNoWallIsLost) {
  const auto map = draw_walls(room(), 50);
  ASSERT_TRUE(map.ok());
  const GridMap small = coarser(*map, 600);
  EXPECT_LE(small.cells.size(), 600U);
  for (double x = 0; x <= 4000; x += 10) EXPECT_EQ(cell_at(small, x, 0), Cell::kOccupied) << x;
  EXPECT_EQ(cell_at(small, 2000, 1000), Cell::kFree);
  EXPECT_EQ(coarser(*map, map->cells.size()).cells, map->cells);
}

TEST(GridMap, APartHasTheRobotInside) {
  const auto map = draw_walls(room(), 50);  // 101 x 61 cells
  ASSERT_TRUE(map.ok());
  GridMapData message;
  for (double x = -400; x <= 4400; x += 90)
    for (double y = -400; y <= 2400; y += 90) {
      to_message(*map, part_around(*map, {x, y}, 30), message);
      const auto part = read_map(message);
      ASSERT_TRUE(part.ok());
      EXPECT_EQ(part->rows, 30);
      EXPECT_EQ(part->columns, 30);
      EXPECT_EQ(cell_at(*part, x, y), cell_at(*map, x, y));
    }
  EXPECT_EQ(part_around(*map, {1e30, -1e30}, 30).rows, 30) << "also far away";
  const GridPart all{0, 0, map->rows, map->columns};
  EXPECT_EQ(part_around(*map, {0, 0}, 1000), all) << "all of a small one";
}

TEST(GridMap, MessagesThatAreNoMaps) {
  EXPECT_FALSE(read_map(GridMapData{}).ok());
  GridMapData message{.scale = 50, .gridNumX = 3, .gridNumY = 3};
  message.occupancy.assign(8, 0);
  EXPECT_FALSE(read_map(message).ok());
}

}  // namespace grid_map_test

}  // namespace rack::localisation
