// Maps of a building that is known, from drives with odometry that errs.
#include "components/mapping/map_maker.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "components/mapping/building_fixture.h"
#include "components/mapping/occupancy.h"

namespace rack::mapping {

namespace map_maker_test {

using localisation::Cell;
using test::Building;

bool go_on(std::string_view /*what*/, std::size_t /*done*/, std::size_t /*all*/) { return true; }

// The error of each pose relative to the first one.
double most_off(const std::vector<Pose>& poses, const std::vector<Pose>& truth) {
  double most = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose is = poses[i] - poses.front();
    const Pose should = truth[i] - truth.front();
    most = std::max(most, std::hypot(is.x - should.x, is.y - should.y));
  }
  return most;
}

TEST(MapMaker, MakesAMapOfABuilding) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Building building(seed);
    const Drive drive = building.drive(60000, 100, radians(1));
    std::vector<Pose> odometry;
    odometry.reserve(drive.scans.size());
    for (const DriveScan& scan : drive.scans) odometry.push_back(scan.odometry);
    EXPECT_GT(most_off(odometry, building.truth()), 2000) << "odometry alone";
    const auto made = make_map(drive, {}, go_on);
    ASSERT_TRUE(made.ok());
    ASSERT_EQ(made->poses.size(), drive.scans.size());
    EXPECT_LT(most_off(made->poses, building.truth()), 120);
    EXPECT_GT(made->loops, 3U);
    EXPECT_EQ(made->unmatched, 0U);
    // The corridor is 16 m x 12 m without its core, the walls are a few cells thick.
    const double cell = made->map.resolution * made->map.resolution / 1e6;
    EXPECT_NEAR(static_cast<double>(made->map.count(Cell::kFree)) * cell, 16 * 12 - 11 * 7, 8);
    EXPECT_LT(static_cast<double>(made->map.count(Cell::kOccupied)) * cell, 12);
  }
}

TEST(MapMaker, GivesTheSameResultAgain) {
  Building building(1);
  const Drive drive = building.drive(15000, 200, 0.01);
  const auto one = make_map(drive, {}, go_on);
  const auto other = make_map(drive, {}, go_on);
  ASSERT_TRUE(one.ok() && other.ok());
  EXPECT_EQ(one->map.cells, other->map.cells);
}

// Slipping wheels: the odometry reports two metres and 20 degrees without a movement.
TEST(MapMaker, FollowsWhenTheOdometryJumps) {
  Building building(4);
  Drive drive = building.drive(50000, 100, 0);
  for (std::size_t i = 150; i < drive.scans.size(); ++i)
    drive.scans[i].odometry = drive.scans[i].odometry + Pose{.x = 0, .rho = 0};
  Pose jump{.x = 300, .y = 100, .rho = 0.3};
  const Pose at = drive.scans[150].odometry;
  for (std::size_t i = 150; i < drive.scans.size(); ++i)
    drive.scans[i].odometry = (at + jump) + (drive.scans[i].odometry - at);
  const auto made = make_map(drive, {}, go_on);
  ASSERT_TRUE(made.ok());
  EXPECT_LT(most_off(made->poses, building.truth()), 150);
}

TEST(MapMaker, EndsWhenItShall) {
  Building building(1);
  const Drive drive = building.drive(50000, 200, 0.01);
  for (const std::string_view last :
       {"matching the scans", "closing loops", "matching all scans against all"}) {
    const auto made =
        make_map(drive, {}, [&](std::string_view what, std::size_t done, std::size_t all) {
          EXPECT_LE(done, all);
          return what != last;
        });
    ASSERT_FALSE(made.ok());
    EXPECT_EQ(made.error(), tims::Errc::kClosed);
  }
}

TEST(MapMaker, SurvivesDrivesThatAreNone) {
  EXPECT_EQ(make_map({}, {}, go_on).error(), tims::Errc::kMalformed);
  Building building(1);
  Drive one = building.drive(0, 100, 0);
  ASSERT_EQ(one.scans.size(), 1U);
  EXPECT_TRUE(make_map(one, {}, go_on).ok());
  Drive blind = one;
  blind.ends.clear();
  blind.scans[0].begin = blind.scans[0].count = 0;
  EXPECT_EQ(make_map(blind, {}, go_on).error(), tims::Errc::kMalformed);

  Drive broken = building.drive(10000, 100, 0);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 10; i < 20; ++i) broken.scans[i].odometry.x = kNan;
  broken.scans[30].odometry.x = 1e9;
  for (std::size_t i = 40; i < 50; ++i) broken.scans[i].count = i % 10;
  const auto made = make_map(broken, {}, go_on);
  if (made.ok()) {
    for (const Pose& pose : made->poses)
      EXPECT_TRUE(std::isfinite(pose.x) && std::isfinite(pose.y));
  } else {
    EXPECT_EQ(made.error(), tims::Errc::kTooBig);
  }
  // The first scans are empty: their poses follow from the odometry.
  Drive late = building.drive(3000, 100, 0);
  for (std::size_t i = 0; i < 5; ++i) late.scans[i].count = 0;
  const auto made_late = make_map(late, {}, go_on);
  ASSERT_TRUE(made_late.ok());
  EXPECT_EQ(made_late->poses.size(), late.scans.size());
}

TEST(Occupancy, CountsWhatEndsAndWhatPasses) {
  auto occupancy = Occupancy::of(50, {0, 0}, {999, 499});
  ASSERT_TRUE(occupancy.ok());
  for (int i = 0; i < 3; ++i) occupancy->add_beam({25, 25}, {825, 25});
  occupancy->add_beam({25, 25}, {425, 25});  // somebody, once
  occupancy->add_beam({std::nan(""), 0}, {0, 0});
  occupancy->add_beam({25, 25}, {5000, 5000});  // leaves the map
  const auto map = occupancy->map();
  EXPECT_EQ(map.rows, 20);
  EXPECT_EQ(map.columns, 10);
  EXPECT_EQ(map.at(16, 0), Cell::kOccupied);
  EXPECT_EQ(map.at(10, 0), Cell::kFree);
  EXPECT_EQ(map.at(17, 0), Cell::kUnknown);
  EXPECT_EQ(map.at(0, 9), Cell::kUnknown);
  EXPECT_EQ(Occupancy::of(50, {0, 0}, {1e9, 1e9}).error(), tims::Errc::kTooBig);
  EXPECT_FALSE(Occupancy::of(50, {0, 0}, {-1e9, 5}).ok());
}

}  // namespace map_maker_test

}  // namespace rack::mapping
