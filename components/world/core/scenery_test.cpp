#include "components/world/core/scenery.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "components/geometry/floor_map.h"
#include "components/geometry/pose.h"
#include "components/geometry/random.h"

namespace rack::world {
namespace scenery_test {

struct Plan {
  DxfDrawing drawing;
  std::vector<WallDescription> walls;
};

// Walls here and there, some of them without length.
Plan random_plan(Random& random, std::size_t count, float size) {
  Plan plan;
  for (std::size_t i = 0; i < count; ++i) {
    const DxfPoint from{random.uniform(-size, size), random.uniform(-size, size)};
    DxfPoint to{random.uniform(-size, size), random.uniform(-size, size)};
    if (i % 3 == 0) to = {from.x, to.y};
    if (i % 7 == 0) to = from;
    plan.drawing.lines.push_back({from, to});
    plan.walls.push_back({.from = {from.y, from.x}, .to = {to.y, to.x}});
  }
  return plan;
}

Ray level(const MapPoint& from, double angle, double reach) {
  return {.from = from,
          .x = std::cos(angle),
          .y = std::sin(angle),
          .height = 300,
          .climb = 0,
          .reach = reach};
}

TEST(Scenery, CastsAsFloorMapDoes) {
  constexpr double kReach = 30000;
  Random random(1);
  for (int run = 0; run < 60; ++run) {
    const float size = run % 2 == 0 ? 8000.0F : 60000.0F;
    const Plan plan = random_plan(random, 40, size);
    const FloorMap map(plan.drawing, 1, 0, 0);
    const Scenery scenery(plan.walls, {});
    for (int from = 0; from < 20; ++from) {
      const MapPoint at{random.uniform(-1.2F * size, 1.2F * size),
                        random.uniform(-1.2F * size, 1.2F * size)};
      std::vector<double> ranges(181);
      const RayFan fan{at, random.uniform(0, 6), radians(0.5)};
      map.cast(fan, kReach, ranges);
      for (std::size_t i = 0; i < ranges.size(); ++i) {
        const auto hit =
            scenery.cast(level(at, fan.first + fan.step * static_cast<double>(i), kReach));
        ASSERT_NEAR(std::min(hit.range, kReach), ranges[i], 0.01) << "run " << run << " ray " << i;
      }
    }
  }
}

TEST(Scenery, RaysAlongTheAxesMeetWhatIsThere) {
  const std::vector<WallDescription> walls = {{.from = {1000, -1000}, .to = {1000, 1000}}};
  const Scenery scenery(walls, {});
  EXPECT_NEAR(scenery.cast(level({0, 0}, 0, 5000)).range, 1000, 1e-9);
  EXPECT_EQ(scenery.cast(level({0, 0}, 0, 999)).met, Met::kNothing);
  EXPECT_EQ(scenery.cast(level({0, 0}, kPi, 5000)).met, Met::kNothing);
  EXPECT_EQ(scenery.cast(level({0, 1001}, 0, 5000)).met, Met::kNothing);
  EXPECT_NEAR(scenery.cast(level({0, 1000}, 0, 5000)).range, 1000, 1e-9);
}

TEST(Scenery, LooksOverLowWallsAndOntoBoxes) {
  const std::vector<WallDescription> walls = {
      {.from = {1000, -1000}, .to = {1000, 1000}, .height = 200},
      {.from = {5000, -1000}, .to = {5000, 1000}, .height = 2500}};
  const std::vector<ObstacleDescription> boxes = {
      {.at = {3000, 0}, .length = 1000, .width = 400, .height = 250}};
  const Scenery scenery(walls, boxes);
  EXPECT_NEAR(scenery.cast(level({0, 0}, 0, 9000)).range, 5000, 1e-9);
  Ray down = level({0, 0}, 0, 9000);
  down.climb = -0.02;  // 240 mm high at the box, 280 at the first wall
  const auto hit = scenery.cast(down);
  EXPECT_EQ(hit.met, Met::kObstacle);
  EXPECT_NEAR(hit.range, 2500, 1e-9);
  down.climb = -0.016;  // above its front, below its top behind it
  EXPECT_NEAR(scenery.cast(down).range, 50 / 0.016, 1e-6);
  down.climb = 1;
  EXPECT_EQ(scenery.cast(down).met, Met::kNothing);
}

TEST(Scenery, ClearanceIsThatOfFloorMap) {
  Random random(2);
  const Plan plan = random_plan(random, 30, 9000);
  const FloorMap map(plan.drawing, 1, 0, 0);
  const Scenery scenery(plan.walls, {});
  for (int i = 0; i < 3000; ++i) {
    const MapPoint at{random.uniform(-11000, 11000), random.uniform(-11000, 11000)};
    EXPECT_NEAR(scenery.clearance(at, 1500), std::min(1500.0, map.clearance(at)), 1e-6);
  }
}

}  // namespace scenery_test
}  // namespace rack::world
