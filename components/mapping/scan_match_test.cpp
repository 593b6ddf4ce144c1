#include "components/mapping/scan_match.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "components/mapping/building_fixture.h"
#include "components/mapping/scan_search.h"

namespace rack::mapping {

namespace scan_match_test {

using test::Building;

std::vector<ScanPoint2d> scan_at(Building& building, const Pose& from) {
  Drive drive;
  building.add_scan(drive, from, {}, 0);
  return points_of(drive.ends, {});
}

TEST(ScanMatch, FindsAPoseNearbyToMillimetres) {
  Building building(1);
  for (double distance = 0; distance < 40000; distance += 1700) {
    const Pose here = Building::place(distance);
    const Pose there = here + Pose{.x = 120, .y = -60, .rho = 0.06};
    const PointIndex index(scan_at(building, here));
    const auto found = match(index, scan_at(building, there), {});
    ASSERT_TRUE(found.has_value()) << distance;
    const Pose off = found->pose - (there - here);
    EXPECT_LT(std::hypot(off.x, off.y), 40) << distance;
    EXPECT_LT(std::abs(signed_angle(off.rho)), radians(0.6)) << distance;
    EXPECT_GT(found->share, 0.8) << distance;
  }
}

// Two bare walls: the position along them is not determined.
TEST(ScanMatch, DoesNotDetermineThePositionAlongACorridor) {
  std::vector<BeamEnd> ends;
  for (float x = 3000; x > -3000; x -= 50) ends.push_back({x, 1000});
  for (float x = -3000; x < 3000; x += 50) ends.push_back({x, -1000});
  const auto points = points_of(ends, {});
  const auto found = match(PointIndex(points), points, {.y = 50});
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->pose.y, 0, 1);
  EXPECT_LT(found->information(0, 0), 1e-4 * found->information(1, 1));
}

// A wall is seen from two sides: its other one is another wall.
TEST(ScanMatch, DistinguishesTheTwoSidesOfAWall) {
  const ScanPoint2d point{.x = 0, .y = 0, .nx = 1, .ny = 0};
  const ScanPoint2d behind{.x = 20, .y = 0, .nx = -1, .ny = 0};
  const ScanPoint2d before{.x = -90, .y = 0, .nx = 1, .ny = 0};
  const PointIndex index(std::vector{behind, before});
  const ScanPoint2d* nearest = index.nearest(point, 300);
  ASSERT_NE(nearest, nullptr);
  EXPECT_EQ(nearest->x, -90);
  EXPECT_EQ(index.nearest(point, 50), nullptr);
}

TEST(ScanMatch, SurvivesWhatIsNoScan) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Building building(1);
  const auto scan = scan_at(building, Building::place(0));
  EXPECT_FALSE(match(PointIndex({}), scan, {}));
  EXPECT_FALSE(match(PointIndex(scan), {}, {}));
  EXPECT_FALSE(match(PointIndex(scan), scan, {.x = 1e7}));
  const std::vector<ScanPoint2d> broken(50, {kNan, kNan, 1, 0});
  EXPECT_FALSE(match(PointIndex(broken), broken, {}));
  EXPECT_FALSE(match(PointIndex(scan), broken, {}));
  const std::vector<ScanPoint2d> wide{{-1e8F, 0, 1, 0}, {1e8F, 1e8F, 1, 0}};
  EXPECT_TRUE(PointIndex(wide).empty()) << "more cells than there is memory for";
  EXPECT_TRUE(points_of({}, {}).empty());
}

TEST(ScanSearch, FindsTheBestPoseOfTheWindow) {
  Building building(2);
  const Pose here = Building::place(5000);
  const ScanSearch search(scan_at(building, here));
  for (const Pose& step :
       {Pose{.x = 700, .y = -300, .rho = 0.2}, Pose{.x = -400, .y = 350, .rho = -0.3}}) {
    const auto scan = scan_at(building, here + step);
    const auto found = search.find(scan, {}, {.distance = 1000, .turn = 0.4}, 0.2);
    ASSERT_TRUE(found.has_value());
    const Pose off = found->pose - step;
    EXPECT_LT(std::hypot(off.x, off.y), 120);
    EXPECT_LT(std::abs(signed_angle(off.rho)), radians(1));
    // Exact: a smaller window around any other pose has nothing better.
    for (double x = -900; x <= 900; x += 300)
      for (double y = -900; y <= 900; y += 300)
        EXPECT_FALSE(search.find(scan, {.x = x, .y = y}, {.distance = 50, .turn = 0.4},
                                 found->score + 0.01));
  }
}

TEST(ScanSearch, SurvivesWhatIsNoScan) {
  Building building(2);
  const auto scan = scan_at(building, Building::place(0));
  EXPECT_FALSE(ScanSearch({}).find(scan, {}, {}, 0));
  EXPECT_FALSE(ScanSearch(scan).find({}, {}, {}, 0));
  EXPECT_FALSE(ScanSearch(scan).find(scan, {.x = 1e12}, {}, 0));
  const std::vector<ScanPoint2d> wide{{-1e8F, 0, 1, 0}, {1e8F, 1e8F, 1, 0}};
  EXPECT_FALSE(ScanSearch(wide).find(scan, {}, {}, 0));
}

}  // namespace scan_match_test

}  // namespace rack::mapping
