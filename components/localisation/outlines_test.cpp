#include "components/localisation/outlines.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack::localisation {

namespace outlines_test {

using testing::HasSubstr;

// One text a row, the northernmost first.
GridMap map_of(const std::vector<std::string>& rows) {
  GridMap map{.resolution = 100,
              .origin = {1000, -500},
              .rows = static_cast<std::int32_t>(rows.size()),
              .columns = static_cast<std::int32_t>(rows[0].size())};
  for (std::size_t row = rows.size(); row-- > 0;)
    for (const char c : rows[row])
      map.cells.push_back(c == '#' ? Cell::kOccupied : c == '?' ? Cell::kUnknown : Cell::kFree);
  return map;
}

GridMap empty(std::int32_t rows, std::int32_t columns) {
  GridMap map{.resolution = 50, .rows = rows, .columns = columns};
  map.cells.resize(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
  return map;
}
Cell& cell(GridMap& map, std::int32_t row, std::int32_t column) {
  return map.cells[static_cast<std::size_t>(row * map.columns + column)];
}

double distance(const MapLine& line, const MapPoint& point) {
  const double dx = line.to.x - line.from.x;
  const double dy = line.to.y - line.from.y;
  const double square = dx * dx + dy * dy;
  const double px = point.x - line.from.x;
  const double py = point.y - line.from.y;
  const double part = square == 0 ? 0 : std::clamp((px * dx + py * dy) / square, 0.0, 1.0);
  return std::hypot(px - part * dx, py - part * dy);
}

double distance(const std::vector<MapLine>& lines, const MapPoint& point) {
  double least = 1e9;
  for (const MapLine& line : lines) least = std::min(least, distance(line, point));
  return least;
}

TEST(Outlines, ARectangleHasFourLines) {
  const auto made = outlines(map_of({"?....", ".###.", ".###.", "....."}), 100);
  ASSERT_TRUE(made) << made.error().detail();
  ASSERT_EQ(made->lines.size(), 4U);
  double length = 0;
  for (const MapLine& line : made->lines) {
    length += std::hypot(line.to.x - line.from.x, line.to.y - line.from.y);
    for (const MapPoint& end : {line.from, line.to}) {
      EXPECT_TRUE(end.x == 1100 || end.x == 1300) << end.x;
      EXPECT_TRUE(end.y == -400 || end.y == -100) << end.y;
    }
  }
  EXPECT_DOUBLE_EQ(length, 1000);
}

TEST(Outlines, AThinWallIsALineInItsMiddle) {
  const auto made = outlines(map_of({".....", ".####", "....."}), 100);
  ASSERT_TRUE(made);
  ASSERT_EQ(made->lines.size(), 1U);
  EXPECT_DOUBLE_EQ(made->lines[0].from.x, 1150);
  EXPECT_DOUBLE_EQ(made->lines[0].to.x, 1150);
  EXPECT_DOUBLE_EQ(std::abs(made->lines[0].to.y - made->lines[0].from.y), 400);
}

TEST(Outlines, WallsAtTheBorderAndAroundRooms) {
  // The room has an outline inside and one outside.
  EXPECT_EQ(outlines(map_of({"####", "#..#", "#..#", "####"}), 100)->lines.size(), 8U);
  EXPECT_EQ(outlines(map_of({"#"}), 100)->lines.size(), 4U);
  EXPECT_EQ(outlines(map_of({"#.#"}), 100)->lines.size(), 8U);
}

// Cells that touch at a corner are one group.
TEST(Outlines, ADiagonalWallIsOneGroup) {
  GridMap map = empty(60, 60);
  for (std::int32_t i = 5; i < 55; ++i) cell(map, i, i) = Cell::kOccupied;
  const auto made = outlines(map, 100);
  ASSERT_TRUE(made);
  EXPECT_LE(made->lines.size(), 6U);
  for (std::int32_t i = 5; i < 55; ++i)
    EXPECT_LT(distance(made->lines, {(i + 0.5) * 50, (i + 0.5) * 50}), 50);
}

// Whatever the direction of a wall: few lines, and none far from the cells.
TEST(Outlines, WallsOfAnyDirectionAreFewLines) {
  for (int degrees = 0; degrees < 180; degrees += 7) {
    GridMap map = empty(400, 400);
    const double angle = degrees * kPi / 180;
    for (double along = -180; along <= 180; along += 0.25)
      cell(map, static_cast<std::int32_t>(200 + along * std::sin(angle)),
           static_cast<std::int32_t>(200 + along * std::cos(angle))) = Cell::kOccupied;
    const auto made = outlines(map, 1000);
    ASSERT_TRUE(made);
    EXPECT_LE(made->lines.size(), 40U) << degrees;
    EXPECT_DOUBLE_EQ(made->error, 47.5);
    for (const MapLine& line : made->lines)
      for (const double part : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        const double x = line.from.x + part * (line.to.x - line.from.x) - 10000;
        const double y = line.from.y + part * (line.to.y - line.from.y) - 10000;
        EXPECT_LT(std::abs(x * std::cos(angle) - y * std::sin(angle)), 100) << degrees;
      }
  }
}

// Every border of a random map is within the stated error of a line.
TEST(Outlines, AreWithinTheirError) {
  std::mt19937 random(5);
  for (int round = 0; round < 50; ++round) {
    GridMap map = empty(30, 30);
    for (Cell& at : map.cells) at = random() % 3 == 0 ? Cell::kOccupied : Cell::kFree;
    const auto made = outlines(map, 20000);
    ASSERT_TRUE(made);
    for (std::int32_t row = 0; row < 30; ++row)
      for (std::int32_t column = 0; column + 1 < 30; ++column) {
        if ((map.at(row, column) == Cell::kOccupied) !=
            (map.at(row, column + 1) == Cell::kOccupied)) {
          EXPECT_LE(distance(made->lines, {(row + 0.5) * 50, (column + 1) * 50.0}),
                    made->error + 1e-6);
        }
      }
  }
}

TEST(Outlines, AreSimplifiedMoreWhenTheyAreTooMany) {
  GridMap map = empty(100, 100);
  for (std::int32_t row = 0; row < 100; row += 2)
    for (std::int32_t column = 0; column < 100; column += 2)
      cell(map, row, column) = Cell::kOccupied;
  EXPECT_EQ(outlines(map, 10000)->lines.size(), 10000U);
  const auto coarse = outlines(map, 9999);
  ASSERT_TRUE(coarse);
  EXPECT_EQ(coarse->lines.size(), 2500U) << "a line each";
  EXPECT_DOUBLE_EQ(coarse->error, 75);
  EXPECT_EQ(outlines(map, 2500)->lines.size(), 2500U);
  const auto refused = outlines(map, 2499);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().detail(), HasSubstr("more than 2499 lines, also with an error of 3"));
}

TEST(Outlines, RefuseAMapWithoutWalls) {
  EXPECT_EQ(outlines(empty(3, 3), 100).error().detail(), "the map has no occupied cells");
  EXPECT_EQ(outlines(GridMap{}, 100).error().detail(), "the map has no occupied cells");
}

// A chequered map has a border around each cell.
TEST(Outlines, NoiseIsBoundedInTimeAndMemory) {
  GridMap map = empty(3000, 3000);
  for (std::int32_t row = 0; row < 3000; ++row)
    for (std::int32_t column = row % 2; column < 3000; column += 2)
      cell(map, row, column) = Cell::kOccupied;
  EXPECT_FALSE(outlines(map, 20000));
}

}  // namespace outlines_test

}  // namespace rack::localisation
