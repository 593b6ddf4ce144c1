#include "components/geometry/floor_map.h"

#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack {

namespace floor_map_test {

// A room of 4 by 2 m, longer from north to south; drawn in metres.
FloorMap room() {
  DxfDrawing drawing;
  drawing.lines = {{{-1, -2}, {1, -2}}, {{1, -2}, {1, 2}}, {{1, 2}, {-1, 2}}, {{-1, 2}, {-1, -2}}};
  return {drawing, 1000, 0, 0};
}

double look(const FloorMap& map, double degrees, MapPoint from = {}) {
  std::array<double, 1> range{};
  map.cast({from, radians(degrees), 1}, 10000, range);
  return range[0];
}

TEST(FloorMap, LooksAroundInARoom) {
  const FloorMap map = room();
  EXPECT_EQ(map.size(), 4U);
  EXPECT_NEAR(look(map, 0), 2000, 1e-6);
  EXPECT_NEAR(look(map, 90), 1000, 1e-6);
  EXPECT_NEAR(look(map, 180), 2000, 1e-6);
  EXPECT_NEAR(look(map, -90), 1000, 1e-6);
  EXPECT_NEAR(look(map, 90, {0, 900}), 100, 1e-6);
  EXPECT_NEAR(look(map, degrees(std::atan2(1, 2))), std::hypot(1000, 2000), 1e-2) << "a corner";
}

TEST(FloorMap, OffsetsAreTakenOffTheDrawing) {
  DxfDrawing drawing;
  drawing.lines = {{{0, 5}, {10, 5}}};
  const FloorMap map(drawing, 100, 2, 3);
  EXPECT_NEAR(look(map, 0), 300, 1e-6);
  EXPECT_NEAR(map.clearance({0, -400}), std::hypot(300, 100), 1e-6);
}

TEST(FloorMap, NothingIsSeenBeyondTheRange) {
  EXPECT_EQ(look({}, 0), 10000);
  DxfDrawing drawing;
  drawing.lines = {{{-1, 11}, {1, 11}}, {{5, 5}, {5, 5}}};
  EXPECT_EQ(look({drawing, 1000, 0, 0}, 0), 10000);
}

TEST(FloorMap, SeenFromAWallItIsNear) {
  EXPECT_NEAR(look(room(), 90, {0, 1000}), 0, 1e-6);
  EXPECT_NEAR(look(room(), -90, {0, 1000}), 0, 1e-6);
}

TEST(FloorMap, AFanSeesWhatItsRaysSee) {
  std::minstd_rand random(1);
  std::uniform_real_distribution<double> place(-8, 8);
  DxfDrawing drawing;
  for (int i = 0; i < 300; ++i)
    drawing.lines.push_back({{place(random), place(random)}, {place(random), place(random)}});
  const FloorMap map(drawing, 1000, 0, 0);
  std::array<double, 361> ranges{};
  map.cast({{100, 200}, radians(-180 + 33), radians(1)}, 10000, ranges);
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const double degrees = -180 + 33 + static_cast<double>(i);
    EXPECT_NEAR(ranges[i], look(map, degrees, {100, 200}), 1e-6) << degrees;
  }
}

TEST(FloorMap, FromInsideNoRayGetsOut) {
  const FloorMap map = room();
  std::array<double, 3600> ranges{};
  map.cast({{-300, 123}, 0.001, radians(0.1)}, 10000, ranges);
  for (const double range : ranges) EXPECT_LT(range, 4500);
}

TEST(FloorMap, Clearance) {
  EXPECT_NEAR(room().clearance({0, 0}), 1000, 1e-6);
  EXPECT_NEAR(room().clearance({1900, 500}), 100, 1e-6);
  EXPECT_TRUE(std::isinf(FloorMap().clearance({0, 0})));
}

}  // namespace floor_map_test

}  // namespace rack
