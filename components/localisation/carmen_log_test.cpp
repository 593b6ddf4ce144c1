#include "components/localisation/carmen_log.h"

#include <array>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

namespace rack::localisation {

namespace carmen_log_test {

TEST(CarmenLog, ReadsScansOfBothKinds) {
  const auto log = read_carmen(
      "# remark\nPARAM robot_length 0.5 1.0 host 0.0\n"
      "ODOM 0 0 0 0.1 0 0 10.0 host 0.0\nODOM 1 0 0 0.1 0 0 11.0 host 1.0\n"
      "FLASER 2 1.5 80.0 0.1 0 0.5 0.0 0 0.5 10.5 host 0.5\r\n"
      "ROBOTLASER1 0 -0.5 1.0 0.5 30 0.01 0 3 1 2 3 1 7 0 0 0 0 0 0 0 0 0 0 0 10.8 host 0.8\n");
  ASSERT_TRUE(log.ok()) << log.error().detail();
  ASSERT_EQ(log->scans.size(), 2U);
  EXPECT_DOUBLE_EQ(log->scans[0].time, 10.5);
  EXPECT_DOUBLE_EQ(log->scans[0].logger_time, 0.5);
  EXPECT_NEAR(log->scans[0].laser.x, 100 * std::cos(0.5), 1e-9);
  EXPECT_NEAR(log->scans[0].laser.y, 100 * std::sin(0.5), 1e-9);
  EXPECT_DOUBLE_EQ(log->scans[1].first, 0.5);
  EXPECT_DOUBLE_EQ(log->scans[1].step, -0.5);
  std::vector<BeamEnd> beams;
  log->beams(log->scans[1], beams);
  ASSERT_EQ(beams.size(), 3U);
  EXPECT_NEAR(beams[1].x, 2000, 0.01);
  EXPECT_NEAR(beams[1].y, 0, 0.01);
  EXPECT_GT(beams[0].y, 0) << "the first is on the right";
  log->beams(log->scans[0], beams);
  EXPECT_EQ(beams.size(), 1U) << "80 m is nothing seen";
}

TEST(CarmenLog, ScansWithoutPosesAreWhereTheOdometryWas) {
  const std::string scan =
      "RAWLASER1 4 -2.35619 4.71239 1.5708 30.0 0.01 0 4 1 2 3 30 0 10.5 h 0.5\r\n";
  const auto log =
      read_carmen("ODOM 0 0 0 0 0 0 10.0 h 0\n" + scan + "ODOM 2 0 0 0 0 0 11.0 h 1\n");
  ASSERT_TRUE(log.ok()) << log.error().detail();
  EXPECT_NEAR(log->scans[0].odometry.y, 1000, 1e-9);
  EXPECT_NEAR(log->scans[0].first, radians(135), 1e-4);
  EXPECT_NEAR(log->range_max, 29.55, 1e-6);
  EXPECT_NE(read_carmen(scan).error().detail().find("without ODOM"), std::string::npos);
}

// For a scanner whose number of beams is not known, the caller gives the field of view.
TEST(CarmenLog, ScannersOfManyKinds) {
  const auto step_of = [](std::size_t count, double field) {
    std::string line = "FLASER " + std::to_string(count);
    for (std::size_t i = 0; i < count; ++i) line += " 5";
    const auto log = read_carmen(line + " 0 0 0 0 0 0 1 h 1\n", field);
    EXPECT_TRUE(log.ok());
    const LogScan& scan = log->scans[0];
    return std::array{degrees(scan.first), -degrees(scan.step)};
  };
  const auto expect = [&](std::size_t count, double field, double first, double step) {
    EXPECT_NEAR(step_of(count, field)[0], first, 1e-9) << count;
    EXPECT_NEAR(step_of(count, field)[1], step, 1e-9) << count;
  };
  expect(180, 0, 90, 1);
  expect(181, 0, 90, 1);
  expect(361, 0, 90, 0.5);
  expect(541, 0, 135, 0.5);
  expect(1081, 0, 135, 0.25);
  expect(401, 0, 50, 0.25);
  expect(683, 240, 120, 240.0 / 682);
  expect(360, 360, 180, 1);
}

TEST(CarmenLog, OdometryAtTheTimeOfTheScan) {
  const auto log = read_carmen(
      "ODOM 0 0 0 0 0 0 10.0 h 0\nODOM 5 0 0 0 0 0 9.0 h 0\nODOM 1 0 0 0 0 0 11.0 h 0\n"
      "FLASER 1 1 7 0 0 7 0 0 10.5 h 0.5\n");
  ASSERT_TRUE(log.ok());
  // ROS's x is RACK's y.
  EXPECT_NEAR(log->odometry_of(log->scans[0], 0.0).y, 7000, 1e-9) << "the pose from the line";
  EXPECT_NEAR(log->odometry_of(log->scans[0], 0.25).y, 250, 1e-9);
  EXPECT_NEAR(log->odometry_of(log->scans[0], 5).y, 0, 1e-9);
  EXPECT_NEAR(log->odometry_of(log->scans[0], -5).y, 1000, 1e-9) << "time went back: left out";
}

TEST(CarmenLog, ReportsTheBrokenLine) {
  const auto error_of = [](std::string_view text) { return read_carmen(text).error().detail(); };
  EXPECT_EQ(error_of("\nODOM 1 2 three 0 0 0 1 h 1\n"), "line 2: pose: \"three\" is not a number");
  EXPECT_EQ(error_of("FLASER 3 1 2\n"), "line 1: range: the line ends before it");
  EXPECT_EQ(error_of("FLASER 2 1 nan 0 0 0 0 0 0 1 h 1\n"),
            "line 1: range: \"nan\" is not a number");
  EXPECT_EQ(error_of("FLASER -1\n").substr(0, 24), "line 1: number of ranges");
  EXPECT_EQ(error_of("FLASER 99999999999\n").substr(0, 24), "line 1: number of ranges");
  EXPECT_EQ(error_of("FLASER 1 1 1e9 0 0 0 0 0 1 h 1\n"),
            "line 1: pose of the laser: more than 1000 km away");
  EXPECT_NE(error_of("ODOM 0 0 0 0 0 0 1 h 1\n").find("no FLASER"), std::string::npos);
  EXPECT_NE(error_of("").find("no FLASER"), std::string::npos);
}

// The recording program was killed while it wrote.
TEST(CarmenLog, AnIncompleteLastLineIsLeftOut) {
  const std::string good =
      "FLASER 2 1.5 2.5 0 0 0 0 0 0 10.5 h 10.5\nFLASER 2 1 2 0 0 0 1 0 0 11.5 h 11.5";
  const std::size_t first = good.find('\n') + 1;
  for (std::size_t size = first + 1; size <= good.size(); ++size) {
    const auto log = read_carmen(good.substr(0, size));
    ASSERT_TRUE(log.ok()) << size << ": " << log.error().detail();
    // "FLASE" is no message, and the time 11 is only less exact than 11.5.
    const bool names_scan = size >= first + 6;
    const bool complete = size >= good.size() - 2;
    EXPECT_EQ(log->scans.size(), complete ? 2U : 1U) << size;
    EXPECT_EQ(log->ranges.size(), complete ? 4U : 2U) << size;
    EXPECT_EQ(log->cut_line, names_scan && !complete ? 2U : 0U) << size;
  }
  EXPECT_EQ(read_carmen(good + "\n")->cut_line, 0U);
  EXPECT_FALSE(read_carmen("FLASER 2 1.5").ok()) << "nothing is left";
  EXPECT_FALSE(read_carmen("FLASER 2 1.5\n" + good).ok()) << "not the last line";
}

TEST(CarmenLog, AScanWithoutBeams) {
  const auto log = read_carmen("FLASER 0 0 0 0 0 0 0 1 h 1\n");
  ASSERT_TRUE(log.ok()) << log.error().detail();
  std::vector<BeamEnd> beams;
  log->beams(log->scans[0], beams);
  EXPECT_TRUE(beams.empty());
  EXPECT_EQ(estimate_lag(*log), 0);
}

// A robot that turns to and fro in a room that is not round; its scans are `lag` s old.
std::string turning(double lag) {
  std::string text;
  const auto heading = [](double t) { return 0.6 * std::sin(1.5 * t); };
  for (int i = 0; i < 300; ++i) {
    const double t = 0.2 * i;
    const double now = heading(t);
    text += "ODOM 0 0 " + std::to_string(now) + " 0 0 0 " + std::to_string(t) + " h 0\n";
    text += "FLASER 180";
    for (int beam = 0; beam < 180; ++beam) {
      const double angle = heading(t - lag) + radians(beam - 90);
      text += " " + std::to_string(3 + std::cos(3 * angle) + 0.5 * std::sin(5 * angle));
    }
    text += " 0 0 " + std::to_string(now) + " 0 0 " + std::to_string(now) + " " +
            std::to_string(t) + " h 0\n";
  }
  return text;
}

TEST(CarmenLog, SeesHowOldItsScansAre) {
  for (const double lag : {0.0, 0.1, 0.2}) {
    const auto log = read_carmen(turning(lag));
    ASSERT_TRUE(log.ok());
    EXPECT_NEAR(estimate_lag(*log), lag, 0.021) << lag;
  }
}

}  // namespace carmen_log_test

}  // namespace rack::localisation
