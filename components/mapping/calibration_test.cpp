// Systematic errors of the odometry, found by scans.
#include "components/mapping/calibration.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "components/geometry/random.h"
#include "components/mapping/building_fixture.h"

namespace rack::mapping {

namespace calibration_test {

bool go_on(std::string_view /*what*/, std::size_t /*done*/, std::size_t /*all*/) { return true; }

// An odometry that counts 4 % too much, and drifts, measures like a good one afterwards.
TEST(Calibration, FindsWhatIsWrongInEachStep) {
  test::Building building(2);
  Drive drive = building.drive(60000, 100, radians(1));
  const Calibration wrong{.scale = 1.04, .aside = 0.01, .turn_scale = 1.03, .drift = 0};
  drive = corrected(std::move(drive), wrong);
  const auto track = follow(drive, go_on);
  ASSERT_TRUE(track.has_value());
  const Calibration found = calibrate(*track);
  EXPECT_NEAR(found.scale, 1 / 1.04, 0.01);
  EXPECT_NEAR(found.aside, -0.01, 0.006);
  EXPECT_NEAR(found.drift, -radians(1) / 1000, radians(0.3) / 1000);
  const Drive better = corrected(drive, found);
  const auto off = [&](const Drive& of) {
    const Pose went = of.scans.back().odometry - of.scans.front().odometry;
    const Pose should = building.truth().back() - building.truth().front();
    return std::hypot(went.x - should.x, went.y - should.y);
  };
  EXPECT_LT(off(better), 0.4 * off(drive));
}

// Along corridors the odometry turns by noise more than by the robot's turns.
TEST(Calibration, IsNotMisledByNoiseOfTheOdometry) {
  Track track;
  Random random(3);
  const Calibration wrong{.scale = 0.97, .turn_scale = 1.05, .drift = radians(-0.8) / 1000};
  Information sure = Information::Zero();
  sure.diagonal() << 0.01, 0.01, 1e5;
  track.keyframes.emplace_back();
  for (std::size_t i = 0; i < 3000; ++i) {
    const double turn =
        i % 60 < 5 ? radians(9) : radians(0.3) * std::sin(0.1 * static_cast<double>(i));
    const Pose step{.x = 200, .rho = turn};
    Pose odometry = wrong.corrected(step);
    odometry.rho += radians(0.7) * static_cast<double>(random.normal());
    track.edges.push_back({i, i + 1, step, sure});
    track.edges.push_back({i, i + 1, odometry, odometry_information(odometry)});
    track.keyframes.emplace_back();
  }
  const Calibration found = calibrate(track);
  EXPECT_NEAR(found.scale, 1 / 0.97, 0.005);
  EXPECT_NEAR(found.turn_scale, 1 / 1.05, 0.02);
  EXPECT_NEAR(found.drift, radians(0.8) / 1000 / 1.05, radians(0.1) / 1000);
}

TEST(Calibration, ChangesNothingWithoutEnoughSteps) {
  test::Building building(2);
  const auto track = follow(building.drive(5000, 100, radians(1)), go_on);
  ASSERT_TRUE(track.has_value());
  const Calibration found = calibrate(*track);
  EXPECT_EQ(found.scale, 1);
  EXPECT_EQ(found.drift, 0);
  EXPECT_EQ(calibrate({}).scale, 1);
}

TEST(Calibration, KeepsWhatIsNotANumber) {
  Drive drive;
  drive.scans.resize(3);
  drive.scans[1].odometry.x = std::numeric_limits<double>::quiet_NaN();
  drive.scans[2].odometry.x = 1000;
  drive = corrected(std::move(drive), {.scale = 1.1});
  EXPECT_TRUE(std::isnan(drive.scans[1].odometry.x));
  EXPECT_NEAR(drive.scans[2].odometry.x, 1100, 1e-6);
}

}  // namespace calibration_test

}  // namespace rack::mapping
