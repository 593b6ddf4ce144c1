#include "tools/evaluation/mcl_eval/truth.h"

#include <cmath>

#include <gtest/gtest.h>

namespace rack::mcl_eval {

namespace truth_test {

// Three scans, at 100, 101 and 102 s; logger time starts at 0.
localisation::CarmenLog log() {
  std::string text;
  for (int i = 0; i < 3; ++i)
    text +=
        "FLASER 1 1 0 0 0 0 0 0 " + std::to_string(100 + i) + " host " + std::to_string(i) + "\n";
  auto read = localisation::read_carmen(text);
  EXPECT_TRUE(read.ok());
  return std::move(read).value();
}

std::string error_of(std::string_view text) { return read_truth(text, log()).error().detail(); }

TEST(Truth, PosesByIndex) {
  const auto truth = read_truth("# remark\n\n7.5 2 1 0 0\n3 0 0 2 0  # first\r\n", log());
  ASSERT_TRUE(truth.ok()) << truth.error().detail();
  ASSERT_EQ(truth->poses.size(), 2U);
  EXPECT_EQ(truth->poses[0].scan, 0U) << "in the order of the log";
  EXPECT_DOUBLE_EQ(truth->poses[0].laser.x, 2000);
  EXPECT_DOUBLE_EQ(truth->poses[1].laser.y, 1000);
}

TEST(Truth, PosesByTime) {
  const auto truth = read_truth("1.02 1 0 0\n5 1 0 0\n", log());
  ASSERT_TRUE(truth.ok());
  ASSERT_EQ(truth->poses.size(), 1U);
  EXPECT_EQ(truth->poses[0].scan, 1U);
  EXPECT_EQ(truth->beside, 1U);
}

// Times are those of the scans; the quaternion rotates about z; the last numbers of relations are
// angles, not a unit quaternion.
TEST(Truth, PosesWithQuaternions) {
  const auto truth = read_truth("# time x y z qx qy qz qw\n101 1 2 0 0 0 0.6 0.8\n", log());
  ASSERT_TRUE(truth.ok()) << truth.error().detail();
  ASSERT_EQ(truth->poses.size(), 1U);
  EXPECT_EQ(truth->poses[0].scan, 1U);
  EXPECT_DOUBLE_EQ(truth->poses[0].laser.x, 2000);
  EXPECT_NEAR(signed_angle(truth->poses[0].laser.rho - kPi / 2 + 2 * std::atan2(0.6, 0.8)), 0,
              1e-9);
  const auto relations = read_truth("100 101 1 0 0 0 0 1\n100 102 1 0 0 0 0 0.5\n", log());
  ASSERT_TRUE(relations.ok());
  EXPECT_EQ(relations->relations.size(), 2U) << "one of a turn of 1 rad";
}

TEST(Truth, RelationsByTheScansOwnTimes) {
  const auto truth = read_truth("100 102.01 1 0.5 0 0 0 0.25\n100 103 1 0 0 0 0 0\n", log());
  ASSERT_TRUE(truth.ok());
  ASSERT_EQ(truth->relations.size(), 1U);
  EXPECT_EQ(truth->relations[0].from, 0U);
  EXPECT_EQ(truth->relations[0].to, 2U);
  EXPECT_DOUBLE_EQ(truth->relations[0].step.x, 1000);
  EXPECT_DOUBLE_EQ(truth->relations[0].step.y, -500) << "left is left";
  EXPECT_DOUBLE_EQ(truth->relations[0].step.rho, -0.25);
  EXPECT_EQ(truth->beside, 1U);
}

TEST(Truth, ReportsTheBrokenLine) {
  EXPECT_EQ(error_of("1 0 0 0 0\n1 0 x 0 0\n"), "line 2: \"x\" is not a number");
  EXPECT_EQ(error_of("1 2 3\n"),
            "line 1: 3 numbers: neither a pose (4, 5, or 8 with a quaternion) nor a relation (8)");
  EXPECT_EQ(error_of("1 0 0 0 0\n1 0 0 0\n"), "line 2: 4 numbers, but 5 in the lines before");
  EXPECT_EQ(error_of("1 3 0 0 0\n"), "line 1: the log has only 3 scans");
  EXPECT_EQ(error_of("1 0.5 0 0 0\n"), "line 1: the second number is not a scan index");
  EXPECT_EQ(error_of("1 2 3 4 5 6 7 8 9\n"), "line 1: more than 8 numbers");
  EXPECT_EQ(error_of("inf 2 3 4\n"), "line 1: \"inf\" is not a number");
  EXPECT_EQ(error_of("# nothing\n"), "the file contains no poses or relations");
  EXPECT_NE(error_of("50 0 0 0\n").find("another log"), std::string::npos);
}

std::vector<Pose> track() {
  return {
      {.x = 0, .y = 0, .rho = 0}, {.x = 1000, .y = 0, .rho = 1}, {.x = 1000, .y = 2000, .rho = 2}};
}

TEST(TrackError, LaysTheTrackOnTheTruthFirst) {
  const Pose elsewhere{.x = -5000, .y = 300, .rho = 2.5};
  Truth truth;
  for (std::size_t i = 0; i < track().size(); ++i)
    truth.poses.push_back({i, elsewhere + track()[i]});
  for (const double metres : track_error(track(), truth).metres) EXPECT_NEAR(metres, 0, 1e-9);
  for (const double degrees : track_error(track(), truth).degrees) EXPECT_NEAR(degrees, 0, 1e-9);
  truth.poses[1].laser.rho += radians(3);
  EXPECT_NEAR(track_error(track(), truth).degrees[1], 3, 1e-9);
}

TEST(TrackError, ReportsHowAStepDiffersFromARelation) {
  Truth truth;
  truth.relations.push_back({0, 1, {.x = 900, .y = 0, .rho = 1}});
  truth.relations.push_back({1, 2, (track()[2] - track()[1])});
  const TrackError error = track_error(track(), truth);
  ASSERT_EQ(error.metres.size(), 2U);
  EXPECT_NEAR(error.metres[0], 0.1, 1e-9);
  EXPECT_NEAR(error.metres[1], 0, 1e-9);
}

}  // namespace truth_test

}  // namespace rack::mcl_eval
