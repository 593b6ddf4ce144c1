// The stages of the map maker, one by one: each makes the poses better than the one before it.
#include "components/mapping/loops.h"

#include <cmath>

#include <gtest/gtest.h>

#include "components/mapping/building_fixture.h"
#include "components/mapping/keyframes.h"
#include "components/mapping/refine.h"

namespace rack::mapping {

namespace loops_test {

using test::Building;

bool go_on(std::string_view /*what*/, std::size_t /*done*/, std::size_t /*all*/) { return true; }

// The mean of the keyframes, seen from the first one.
double off(const Track& track, const Building& building) {
  double all = 0;
  for (std::size_t i = 0; i < track.poses.size(); ++i) {
    const Pose is = track.poses[i] - track.poses.front();
    const Pose should = building.truth()[track.keyframes[i].scan] - building.truth().front();
    all += std::hypot(is.x - should.x, is.y - should.y);
  }
  return all / static_cast<double>(track.poses.size());
}

TEST(Stages, EachMakesThePosesBetter) {
  Building building(5);
  const Drive drive = building.drive(80000, 100, radians(1.5));
  auto track = follow(drive, go_on);
  ASSERT_TRUE(track.has_value());
  EXPECT_EQ(track->unmatched, 0U);
  const double followed = off(*track, building);
  EXPECT_LT(followed, 1000);
  const auto loops = close_loops(*track, go_on);
  ASSERT_TRUE(loops.has_value());
  EXPECT_GT(loops->edges.size(), 5U);
  for (const Edge& edge : loops->edges) {
    const Pose should = building.truth()[track->keyframes[edge.to].scan] -
                        building.truth()[track->keyframes[edge.from].scan];
    EXPECT_LT(std::hypot(edge.step.x - should.x, edge.step.y - should.y), 200) << "a wrong loop";
  }
  const double closed = off(*track, building);
  EXPECT_LT(closed, std::max(0.7 * followed, 60.0));
  const auto edges = refine(*track, *loops, 3, go_on);
  ASSERT_TRUE(edges.has_value());
  EXPECT_GT(edges->size(), 3 * track->poses.size()) << "most scans lie on several others";
  EXPECT_LT(off(*track, building), std::max(closed, 50.0));
}

// Once along a corridor: nothing to close, and nothing is made up.
TEST(Stages, WithoutALoopThereIsNone) {
  Building building(6);
  const Drive drive = building.drive(20000, 100, radians(1));
  auto track = follow(drive, go_on);
  ASSERT_TRUE(track.has_value());
  const auto loops = close_loops(*track, go_on);
  ASSERT_TRUE(loops.has_value());
  EXPECT_TRUE(loops->edges.empty());
  EXPECT_EQ(all_edges(*track, *loops).size(), track->edges.size());
}

// The information of the odometry decreases with the distance, along more than across.
TEST(Odometry, IsLessSureOfLongerSteps) {
  const Information near = odometry_information({.x = 100});
  const Information far = odometry_information({.x = 1000, .rho = 0.5});
  EXPECT_GT(near(0, 0), far(0, 0));
  EXPECT_GT(near(2, 2), far(2, 2));
  const Information aside = odometry_information({.y = 1000});
  EXPECT_GT(aside(0, 0), aside(1, 1)) << "along is where it went";
}

}  // namespace loops_test

}  // namespace rack::mapping
