#include "components/world/core/shapes.h"

#include <gtest/gtest.h>

#include "components/geometry/pose.h"
#include "components/geometry/random.h"

namespace rack::world {
namespace shapes_test {

TEST(Shapes, RaysEnterAndLeave) {
  const Ray ray{.from = {0, 0}, .x = 1, .y = 0, .reach = 9000};
  const Inside circle = inside(ray, Circle{{1000, 30}, 50});
  EXPECT_NEAR(circle.from, 960, 1e-9);
  EXPECT_NEAR(circle.to, 1040, 1e-9);
  EXPECT_EQ(meets(ray, inside(ray, Circle{{1000, 51}, 50}), 500), kNoHit);
  EXPECT_EQ(meets(ray, inside(ray, Circle{{-1000, 0}, 50}), 500), kNoHit);
  EXPECT_EQ(meets(ray, inside(ray, Circle{{0, 0}, 50}), 500), 0);
  const Inside box = inside(ray, Box::of({1000, 0}, kPi / 2, 200, 400));
  EXPECT_NEAR(box.from, 800, 1e-9);
  EXPECT_NEAR(box.to, 1200, 1e-9);
  EXPECT_EQ(meets(ray, inside(ray, Box::of({1000, 101}, 0, 400, 200)), 500), kNoHit);
  const Solid solid = Solid::of({.shape = Shape::kCircle, .at = {500, 0}, .radius = 100});
  EXPECT_NEAR(meets(ray, solid), 400, 1e-9);
  EXPECT_NEAR(distance({0, 0}, solid), 400, 1e-9);
  EXPECT_EQ(distance({500, 20}, solid), 0);
}

// A box that overlaps has a point of the figure in it, one that does not has none.
TEST(Shapes, BoxesTouchWhatPointsOfItAreInside) {
  Random random(3);
  int touched = 0;
  for (int i = 0; i < 4000; ++i) {
    const auto any = [&](float size) { return random.uniform(-size, size); };
    const Box box = Box::of({any(500), any(500)}, any(3), random.uniform(50, 900), 300);
    const Segment wall{{any(900), any(900)}, {any(900), any(900)}};
    double nearest = kNoHit;
    constexpr int kPoints = 2000;
    for (int k = 0; k <= kPoints; ++k) {
      const double part = static_cast<double>(k) / kPoints;
      nearest = std::min(nearest, distance({wall.from.x + part * (wall.to.x - wall.from.x),
                                            wall.from.y + part * (wall.to.y - wall.from.y)},
                                           box));
    }
    const bool touches = overlap(box, wall);
    touched += touches ? 1 : 0;
    EXPECT_TRUE(touches || nearest > 0) << i;
    EXPECT_TRUE(!touches || nearest <= 2) << i;
  }
  EXPECT_GT(touched, 500);
  EXPECT_LT(touched, 3500);
}

TEST(Shapes, OverlapOfBoxesIsSymmetric) {
  Random random(4);
  int touched = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto any = [&](float size) { return random.uniform(-size, size); };
    const Box a = Box::of({0, 0}, any(3), 800, 300);
    const Box b = Box::of({any(700), any(700)}, any(3), random.uniform(50, 900), 200);
    EXPECT_EQ(overlap(a, b), overlap(b, a));
    touched += overlap(a, b) ? 1 : 0;
    bool has_point = false;
    for (double x = -1; x <= 1; x += 0.1)
      for (double y = -1; y <= 1; y += 0.1) {
        const MapPoint p{b.at.x + x * b.half_length * b.c - y * b.half_width * b.s,
                         b.at.y + x * b.half_length * b.s + y * b.half_width * b.c};
        has_point = has_point || distance(p, a) == 0;
      }
    EXPECT_TRUE(overlap(a, b) || !has_point) << i;
    EXPECT_TRUE(!overlap(a, b) || distance(b.at, a) < b.radius()) << i;
  }
  EXPECT_GT(touched, 200);
}

}  // namespace shapes_test
}  // namespace rack::world
