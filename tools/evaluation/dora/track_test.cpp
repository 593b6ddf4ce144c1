#include "tools/evaluation/dora/track.h"

#include <gtest/gtest.h>

namespace rack::dora {
namespace track_test {

// 10 m to the north, a quarter of a circle to the right, 10 m to the east.
std::vector<PolarSpline> bend() {
  std::vector<PolarSpline> path{path::line({}, 10000)};
  path.push_back(path::arc(path::pose_at(path[0], 10000), 5000, 5000 * kPi / 2));
  path.push_back(path::line(path::pose_at(path[1], 5000 * kPi / 2), 10000));
  return path;
}

TEST(TrackTest, BesideTheLineItIsOn) {
  const auto path = bend();
  const auto place = place_on(path, {.x = 4000, .y = 120, .rho = 0.1});
  ASSERT_TRUE(place);
  EXPECT_EQ(place->spline, 0U);
  EXPECT_NEAR(place->along, 4000, 1);
  EXPECT_NEAR(place->across, 120, 1);
  EXPECT_NEAR(place_on(path, {.x = 4000, .y = -120})->across, -120, 1);
}

TEST(TrackTest, RoundTheBendAndNoFartherThanItsEnd) {
  const auto path = bend();
  const auto place = place_on(path, {.x = 9000});
  const Pose there = ahead_of(path, *place, 1000 + 2500 * kPi + 2000);
  EXPECT_NEAR(there.x, 15000, 5);
  EXPECT_NEAR(there.y, 7000, 5);
  EXPECT_NEAR(rest_of(path, *place), 1000 + 2500 * kPi + 10000, 1);
  EXPECT_NEAR(ahead_of(path, *place, 1e6).y, 15000, 5);
}

TEST(TrackTest, WhereItCrossesItselfTheHeadingDecides) {
  std::vector<PolarSpline> path{path::line({}, 10000),
                                path::line({.x = 5000, .y = 5000, .rho = -kPi / 2}, 10000)};
  EXPECT_EQ(place_on(path, {.x = 5000, .y = 0, .rho = 0})->spline, 0U);
  EXPECT_EQ(place_on(path, {.x = 5000, .y = 0, .rho = -kPi / 2})->spline, 1U);
  EXPECT_FALSE(place_on({}, {}));
}

}  // namespace track_test
}  // namespace rack::dora
