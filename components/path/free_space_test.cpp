#include "components/path/free_space.h"

#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace rack::path {
namespace free_space_test {

TEST(FreeSpace, KnowsHowFarTheNearestObstacleIs) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> any(0, 59);
  auto space = FreeSpace::empty({-3000, 1000}, 6000, 6000, 100);
  ASSERT_TRUE(space.ok());
  std::vector<Place> obstacles;
  for (int i = 0; i < 30; ++i) {
    obstacles.push_back(space->center_of(static_cast<std::size_t>(any(random)),
                                         static_cast<std::size_t>(any(random))));
    space->occupy(obstacles.back());
  }
  space->measure();
  for (std::size_t row = 0; row < 60; ++row) {
    for (std::size_t column = 0; column < 60; ++column) {
      const Place at = space->center_of(row, column);
      double least = 1e9;
      for (const Place& obstacle : obstacles)
        least = std::min(least, std::hypot(at.x - obstacle.x, at.y - obstacle.y));
      const double rim = std::min({at.x + 3000, at.y - 1000, 3000 - at.x, 7000 - at.y});
      EXPECT_NEAR(space->clearance(at), std::max(0.0, std::min(least - 141.42, rim)), 0.1);
    }
  }
}

TEST(FreeSpace, IsNowhereFreeOutside) {
  auto space = FreeSpace::empty({}, 1000, 1000, 50);
  ASSERT_TRUE(space.ok());
  EXPECT_GT(space->clearance({500, 500}), 400);
  EXPECT_EQ(space->clearance({-1, 500}), 0);
  EXPECT_TRUE(space->occupied({500, 1001}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(space->clearance({nan, 500}), 0);
  space->occupy({nan, nan});
}

TEST(FreeSpace, ReadsDrawingsAndMessages) {
  DxfPlan plan;
  plan.drawing.lines = {{{0, 0}, {2, 0}}, {{2, 0}, {2, 3}}};
  const auto drawn = FreeSpace::of(plan, 50, 500);
  ASSERT_TRUE(drawn.ok());
  EXPECT_TRUE(drawn->occupied({10, 1000})) << "x is north";
  EXPECT_TRUE(drawn->occupied({1500, 2010}));
  EXPECT_FALSE(drawn->occupied({1500, 1000}));
  GridMapData map;
  map.scale = 100;
  map.offsetX = 1000;
  map.gridNumX = 3;
  map.gridNumY = 4;
  map.occupancy.resize(12);
  map.occupancy[2 * 3 + 1] = 255;  // x runs first
  const auto grid = FreeSpace::of(map);
  ASSERT_TRUE(grid.ok());
  EXPECT_TRUE(grid->occupied({1100, 200})) << "offsets are of the middle of the first cell";
  EXPECT_TRUE(grid->occupied({1060, 240}));
  EXPECT_FALSE(grid->occupied({1200, 100}));
}

// Three rows of two cells of 100 mm.
localisation::GridMap cells() {
  using enum localisation::Cell;
  return {.resolution = 100,
          .origin = {1000, -300},
          .rows = 3,
          .columns = 2,
          .cells = {kFree, kFree, kFree, kOccupied, kUnknown, kFree}};
}

TEST(FreeSpace, ReadsMapsOfCells) {
  for (const double cell : {25.0, 50.0, 100.0}) {
    const auto space = FreeSpace::of(cells(), cell);
    ASSERT_TRUE(space.ok());
    for (double x = 1010; x < 1300; x += 20)
      for (double y = -290; y < -100; y += 20)
        EXPECT_EQ(space->occupied({x, y}), x > 1100 && x < 1200 && y > -200)
            << x << " " << y << " in cells of " << cell;
  }
  // Cells of 150 mm are occupied where they touch the occupied one.
  const auto coarse = FreeSpace::of(cells(), 150);
  ASSERT_TRUE(coarse.ok());
  for (const Place& place : {Place{1010, -160}, {1160, -110}, {1290, -110}})
    EXPECT_TRUE(coarse->occupied(place)) << place.x;
  EXPECT_FALSE(FreeSpace::of(cells(), 5).ok()) << "too small";
}

TEST(FreeSpace, IsTheSameAsMessage) {
  auto space = FreeSpace::empty({-3000, 1000}, 6000, 2500, 100);
  ASSERT_TRUE(space.ok());
  for (const Place& place : {Place{-2999, 1001}, Place{50, 2000}, Place{2999, 3499}})
    space->occupy(place);
  space->measure();
  const GridMapData message = space->message();
  EXPECT_EQ(message.scale, 100);
  EXPECT_EQ(message.gridNumX, 60);
  EXPECT_EQ(message.gridNumY, 25);
  const auto read = FreeSpace::of(message);
  ASSERT_TRUE(read.ok()) << read.error().message();
  for (std::size_t row = 0; row < space->rows(); ++row)
    for (std::size_t column = 0; column < space->columns(); ++column) {
      const Place at = space->center_of(row, column);
      EXPECT_EQ(read->occupied(at), space->occupied(at)) << at.x << ' ' << at.y;
    }
}

TEST(FreeSpace, HasCoarserCellsInAMessageThatCannotHoldThem) {
  for (const auto& [length, scale] : {std::pair{500.0, 10}, {500.1, 20}}) {  // times 500 cells
    auto space = FreeSpace::empty({}, 10 * length, 5000, 10);
    ASSERT_TRUE(space.ok());
    space->occupy({4985, 4985});
    const GridMapData message = space->message();
    EXPECT_EQ(message.scale, scale);
    const auto read = FreeSpace::of(message);
    ASSERT_TRUE(read.ok()) << read.error().message();
    EXPECT_TRUE(read->occupied({4985, 4985}));
    EXPECT_FALSE(read->occupied({4955, 4985}));
  }
}

TEST(FreeSpace, ReadsFiles) {
  const auto of_ros = FreeSpace::of({.path = "a.yaml", .cells = cells()}, 50, 500);
  ASSERT_TRUE(of_ros.ok());
  EXPECT_EQ(of_ros->rows(), 6U);
  localisation::FloorPlan drawing{.path = "a.dxf"};
  EXPECT_EQ(FreeSpace::of(drawing, 50, 500).error().detail(), "a.dxf: the drawing has no lines");
  drawing.drawing.drawing.lines = {{{0, 0}, {2, 0}}};
  EXPECT_TRUE(FreeSpace::of(drawing, 50, 500).ok());
}

TEST(FreeSpace, RefusesMapsThatAreNone) {
  EXPECT_FALSE(FreeSpace::of(GridMapData{}).ok());
  EXPECT_FALSE(FreeSpace::of(DxfPlan{}, 50, 500).ok());
  EXPECT_FALSE(FreeSpace::empty({}, 0, 1000, 50).ok());
  EXPECT_FALSE(FreeSpace::empty({}, 1000, 1000, 0).ok());
  EXPECT_FALSE(FreeSpace::empty({}, 1e12, 1e12, 50).ok());
  EXPECT_FALSE(FreeSpace::empty({}, std::numeric_limits<double>::quiet_NaN(), 1, 50).ok());
}

// Whatever the hull: every corner of it is in one of its discs.
TEST(HullDiscs, CoverTheHull) {
  for (const HullDiscs::Size& size : {HullDiscs::Size{1700, 600, 600, 50},
                                      {250, 250, 250, 0},
                                      {0, 0, 100, 0},
                                      {5000, 0, 300, 20}}) {
    const HullDiscs hull(size);
    for (double x = -size.back; x <= size.front; x += 10) {
      const double y = size.half_width;
      bool covered = false;
      for (const double center : hull.centers())
        covered = covered || std::hypot(x - center, y) <= hull.radius() + 1e-6;
      EXPECT_TRUE(covered) << x;
    }
    EXPECT_GE(hull.turning_radius(), std::hypot(size.front, size.half_width));
  }
}

}  // namespace free_space_test
}  // namespace rack::path
