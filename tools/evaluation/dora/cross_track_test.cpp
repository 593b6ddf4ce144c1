#include "tools/evaluation/dora/cross_track.h"

#include <gtest/gtest.h>

namespace rack::dora {
namespace cross_track_test {

// 10 m north, a right turn of 90 degrees with 5 m radius, 10 m east.
std::vector<PolarSpline> bend() {
  std::vector<PolarSpline> path{path::line({}, 10000)};
  path.push_back(path::arc(path::pose_at(path[0], 10000), 5000, 5000 * kPi / 2));
  path.push_back(path::line(path::pose_at(path[1], 5000 * kPi / 2), 10000));
  return path;
}

TEST(CrossTrackTest, ReportsTheErrorAcrossTheLine) {
  const auto path = bend();
  const auto position = project_onto(path, {.x = 4000, .y = 120, .rho = 0.1});
  ASSERT_TRUE(position);
  EXPECT_EQ(position->spline, 0U);
  EXPECT_NEAR(position->along, 4000, 1);
  EXPECT_NEAR(position->across, 120, 1);
  EXPECT_NEAR(project_onto(path, {.x = 4000, .y = -120})->across, -120, 1);
}

TEST(CrossTrackTest, LooksAheadAroundTheBendUpToTheEnd) {
  const auto path = bend();
  const auto position = project_onto(path, {.x = 9000});
  const Pose there = ahead_of(path, *position, 1000 + 2500 * kPi + 2000);
  EXPECT_NEAR(there.x, 15000, 5);
  EXPECT_NEAR(there.y, 7000, 5);
  EXPECT_NEAR(remaining_length(path, *position), 1000 + 2500 * kPi + 10000, 1);
  EXPECT_NEAR(ahead_of(path, *position, 1e6).y, 15000, 5);
}

TEST(CrossTrackTest, HeadingDecidesWhereThePathCrossesItself) {
  std::vector<PolarSpline> path{path::line({}, 10000),
                                path::line({.x = 5000, .y = 5000, .rho = -kPi / 2}, 10000)};
  EXPECT_EQ(project_onto(path, {.x = 5000, .y = 0, .rho = 0})->spline, 0U);
  EXPECT_EQ(project_onto(path, {.x = 5000, .y = 0, .rho = -kPi / 2})->spline, 1U);
  EXPECT_FALSE(project_onto({}, {}));
}

}  // namespace cross_track_test
}  // namespace rack::dora
