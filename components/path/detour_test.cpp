#include "components/path/detour.h"

#include <gtest/gtest.h>

#include "components/path/goal_planner.h"
#include "components/path/vehicle.h"

namespace rack::path {
namespace detour_test {

std::vector<PolarSpline> bent() {
  std::vector<PolarSpline> path = {line({}, 5000)};
  path.push_back(arc({.x = 5000}, 5000, 7854));
  path.push_back(line(pose_at(path[1], path[1].length), 5000));
  for (PolarSpline& spline : path) {
    spline.lbo = 2000;
    spline.vMax = 1000;
    spline.accMax = spline.decMax = 500;
  }
  return path;
}

TEST(Detour, FindsPlacesFurtherOn) {
  const auto path = bent();
  const OnPath at = further(path, {0, 4000}, 2000);
  EXPECT_EQ(at.index, 1U);
  EXPECT_NEAR(at.distance, 1000, 1);
  const OnPath end = further(path, {0, 0}, 1e9);
  EXPECT_EQ(end.index, 2U);
  EXPECT_NEAR(end.distance, 5000, 1);
  EXPECT_NEAR(pose_on(path, {0, 4000}).x, 4000, 1);
}

TEST(Detour, AppendsTheRest) {
  const auto path = bent();
  std::vector<PolarSpline> rest;
  append_rest(path, {1, 3000}, rest);
  ASSERT_EQ(rest.size(), 2U);
  EXPECT_EQ(rest[0].length, 4854);
  const Pose cut = pose_on(path, {1, 3000});
  EXPECT_NEAR(pose_at(rest[0], 0).x, cut.x, 1.5);
  const Pose end = pose_at(rest[0], rest[0].length);
  EXPECT_NEAR(end.x, pose_at(path[2], 0).x, 2);
  EXPECT_NEAR(end.y, pose_at(path[2], 0).y, 2);
  append_rest(path, {2, 5000}, rest);
  EXPECT_EQ(rest.size(), 2U) << "nothing is left there";
}

TEST(Detour, LeadsRoundAnObstacleWithinTheCorridor) {
  const auto path = bent();
  auto space = FreeSpace::empty({-5000, -5000}, 20000, 20000, 100);
  ASSERT_TRUE(space.ok());
  // A wall on the line that leaves room on one side.
  space->occupy({3500, -2000}, {3500, 300});
  keep_to_corridor(*space, path, {0, 0}, 1000);
  EXPECT_TRUE(space->occupied({2000, 2500}));
  EXPECT_FALSE(space->occupied({2000, 1500}));
  ChassisParamData chassis;
  chassis.vxMax = 1000;
  chassis.accMax = chassis.decMax = 500;
  chassis.omegaMax = 1;
  chassis.boundaryFront = chassis.boundaryBack = 300;
  chassis.boundaryLeft = chassis.boundaryRight = 250;
  for (const i32 radius : {0, 1000}) {
    chassis.minTurningRadius = radius;
    GoalPlanner planner({.limits = limits_of(chassis), .hull = hull_of(chassis)});
    const OnPath back = further(path, {0, 0}, 6000);
    ASSERT_TRUE(planner.begin(*space, {}, pose_on(path, back)).ok());
    while (planner.advance() == GoalPlanner::Progress::kSearching) {
    }
    std::vector<PolarSpline> whole = planner.path();
    ASSERT_FALSE(whole.empty()) << planner.why();
    append_rest(path, back, whole);
    set_speeds(whole);
    double passes = 0;
    for (const PolarSpline& spline : whole) {
      for (double distance = 0; distance <= size(spline); distance += 50) {
        const Pose at = pose_at(spline, sense(spline) * distance);
        EXPECT_FALSE(space->occupied({at.x, at.y}));
        if (std::abs(at.x - 3500) < 100) passes = at.y;
      }
    }
    EXPECT_GT(passes, 500) << "beside the wall";
    EXPECT_EQ(whole.back().endPos.x, path.back().endPos.x);
    EXPECT_EQ(whole.back().vEnd, 0);
  }
}

}  // namespace detour_test
}  // namespace rack::path
