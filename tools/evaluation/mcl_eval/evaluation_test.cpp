// A synthetic log of a robot that drives around a room, with ground truth.
#include "tools/evaluation/mcl_eval/evaluation.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "components/localisation/ros_map.h"
#include "tools/evaluation/mcl_eval/table.h"

namespace rack::mcl_eval {

namespace evaluation_test {

using localisation::LikelihoodField;

// 30 m x 20 m, with distinguishable parts.
DxfDrawing plan() {
  DxfDrawing drawing;
  const auto wall = [&](double x, double y, double x2, double y2) {
    drawing.lines.push_back({{x, y}, {x2, y2}});
  };
  wall(0, 0, 30, 0);
  wall(30, 0, 30, 20);
  wall(30, 20, 0, 20);
  wall(0, 20, 0, 0);
  wall(8, 0, 8, 3);
  wall(17, 0, 17, 2);
  wall(0, 13, 3, 13);
  wall(12, 20, 12, 17);
  wall(12, 17, 14, 17);
  wall(25, 14, 30, 14);
  wall(12, 9, 18, 9);
  wall(18, 9, 18, 11);
  return drawing;
}

struct Made {
  localisation::CarmenLog log;
  Truth poses;
  Truth relations;
};

Made make() {
  const FloorMap rays(plan(), 1000, 0, 0);
  std::string log;
  std::string poses;
  std::string relations;
  for (int i = 0; i < 500; ++i) {
    // In the frame of ROS, on an ellipse; the odometry has another origin.
    const double part = i * 0.15 / 9;
    const double x = 15 + 10 * std::cos(part);
    const double y = 10 + 6 * std::sin(part);
    const double theta = std::atan2(6 * std::cos(part), -10 * std::sin(part));
    const Pose place = localisation::pose_of_ros(x, y, theta);
    std::array<double, 181> ranges{};
    rays.cast({{place.x, place.y}, place.rho - kPi / 2, kPi / 180}, 80000, ranges);
    log += "FLASER 181";
    for (std::size_t beam = ranges.size(); beam-- > 0;) {
      log += ' ';
      log += std::to_string(ranges[beam] / 1000);
    }
    const std::string odometry = fmt::format("{} {} {}", x - 7, y + 3, theta);
    log += fmt::format(" {0} {0} {1} host {2}\n", odometry, 100 + i, i);
    poses += fmt::format("{0} {0} {1} {2} {3}\n", i, x, y, theta);
    if (i == 0) continue;
    const Pose step =
        place - localisation::pose_of_ros(
                    15 + 10 * std::cos(part - 0.15 / 9), 10 + 6 * std::sin(part - 0.15 / 9),
                    std::atan2(6 * std::cos(part - 0.15 / 9), -10 * std::sin(part - 0.15 / 9)));
    relations += fmt::format("{} {} {} {} 0 0 0 {}\n", 99 + i, 100 + i, step.x / 1000,
                             -step.y / 1000, -signed_angle(step.rho));
  }
  auto read = localisation::read_carmen(log);
  EXPECT_TRUE(read.ok());
  auto by_pose = read_truth(poses, *read);
  auto by_relation = read_truth(relations, *read);
  EXPECT_TRUE(by_pose.ok() && by_relation.ok());
  return {std::move(*read), std::move(*by_pose), std::move(*by_relation)};
}

LikelihoodField field() {
  auto made = LikelihoodField::of(*localisation::read_map(plan(), 1000, 0, 0, 50), {});
  EXPECT_TRUE(made.ok());
  return std::move(made).value();
}

class EvaluationTest : public testing::Test {
 protected:
  Outcome evaluate(const Trial& trial, const Truth& truth) {
    return run(trial, made_.log, field_, truth, [this] { return us_ += 5; });
  }
  Made made_ = make();
  LikelihoodField field_ = field();
  double us_ = 0;
};

TEST_F(EvaluationTest, Poses) {
  const Outcome outcome = evaluate({}, made_.poses);
  EXPECT_EQ(outcome.metres.size(), 499U) << "the first is not compared";
  EXPECT_LT(quantile(outcome.metres, 0.5), 0.06);
  EXPECT_LT(quantile(outcome.degrees, 0.5), 0.6);
  EXPECT_FALSE(outcome.lost);
  EXPECT_DOUBLE_EQ(outcome.us_per_update, 5);
  EXPECT_GT(outcome.updates, 400U);
}

TEST_F(EvaluationTest, Relations) {
  const Outcome outcome = evaluate({}, made_.relations);
  EXPECT_EQ(outcome.metres.size(), 499U);
  EXPECT_LT(quantile(outcome.metres, 0.5), 0.04);
  EXPECT_FALSE(outcome.lost);
}

TEST_F(EvaluationTest, AGlobalStartCountsFromWhereItWasFound) {
  const Outcome outcome = evaluate({.global = true}, made_.poses);
  ASSERT_TRUE(outcome.found_after.has_value());
  EXPECT_LT(*outcome.found_after, 15);
  EXPECT_LT(quantile(outcome.metres, 0.5), 0.06);
}

TEST_F(EvaluationTest, CarriedAway) {
  ASSERT_TRUE(kidnapping(made_.poses).has_value());
  EXPECT_FALSE(kidnapping(made_.relations).has_value());
  const Outcome outcome = evaluate({.kidnap = kidnapping(made_.poses)}, made_.poses);
  EXPECT_GT(quantile(outcome.metres, 1), 3);
  ASSERT_TRUE(outcome.refound_after.has_value());
  EXPECT_LT(*outcome.refound_after, 20);
  EXPECT_GT(outcome.recoveries, 0U);
  EXPECT_FALSE(outcome.lost);
}

// There and back, also to places that the robot has passed before.
TEST_F(EvaluationTest, CarriedFromAnywhereToAnywhere) {
  EXPECT_TRUE(journeys(made_.relations, 10, 1).empty());
  const auto all = journeys(made_.poses, 10, 1);
  ASSERT_EQ(all.size(), 10U);
  bool back = false;
  std::uint64_t seed = 0;
  for (const Journey& journey : all) {
    EXPECT_LT(made_.poses.poses[journey.begin].scan, journey.kidnapping.leave);
    back = back || journey.kidnapping.arrive < journey.kidnapping.leave;
    const Outcome outcome = evaluate(
        {.seed = ++seed, .kidnap = journey.kidnapping, .begin = journey.begin, .distance_max = 20},
        made_.poses);
    EXPECT_TRUE(outcome.refound_after.has_value()) << seed;
    EXPECT_LT(outcome.updates, 600U) << "it ends";
  }
  EXPECT_TRUE(back);
}

TEST_F(EvaluationTest, TheTableReportsFailedRequirements) {
  std::vector<Recording> all;
  all.push_back({"fr079", made_.log, field_, {}, made_.poses, {}});
  std::vector<Row> rows;
  const auto keep = [&](const Row& row) { rows.push_back(row); };
  const auto now = [this] { return us_ += 5; };
  EXPECT_TRUE(measure(all, 2, true, now, keep));
  ASSERT_EQ(rows.size(), 5U);
  EXPECT_EQ(rows[0].measured, "0 of 2");
  for (TruePose& pose : all[0].poses.poses) pose.laser.x += 5000;
  rows.clear();
  EXPECT_FALSE(measure(all, 1, true, now, keep));
  EXPECT_FALSE(rows[0].held);
  EXPECT_EQ(rows[0].measured, "1 of 1");
}

TEST_F(EvaluationTest, MadeHarder) {
  const Outcome outcome =
      evaluate({.odometry_scale = 1.1, .odometry_drift = 5, .short_beams = 0.3}, made_.poses);
  EXPECT_GT(quantile(outcome.metres, 0.5), 0.02);
  EXPECT_FALSE(outcome.lost);
}

// The map of another room: localisation must fail.
TEST_F(EvaluationTest, ReportsWhenItIsLost) {
  for (TruePose& pose : made_.poses.poses) pose.laser.x += 5000;
  const Outcome outcome = evaluate({}, made_.poses);
  EXPECT_TRUE(outcome.lost);
  EXPECT_GT(outcome.share_over_1m, 0.5);
}

TEST_F(EvaluationTest, KeepsPosesWhenTheyAreWanted) {
  EXPECT_TRUE(evaluate({}, made_.poses).poses.empty());
  const Outcome outcome = evaluate({.keep_poses = true}, made_.poses);
  ASSERT_GE(outcome.poses.size(), 499U);
  const PoseRow& first = outcome.poses.front();
  ASSERT_TRUE(first.truth);
  EXPECT_NEAR(first.odometry.x, first.truth->x, 1e-6) << "it begins where the truth does";
  const std::string text = to_csv(outcome.poses);
  EXPECT_TRUE(text.starts_with("time_s,x_m,y_m,heading_deg,odometry_x_m,"));
  EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(text, '\n')), outcome.poses.size() + 1);
  EXPECT_EQ(to_csv({}).back(), '\n');
  PoseRow alone;
  EXPECT_TRUE(to_csv({&alone, 1}).ends_with(",,,,,\n")) << "no truth";
}

}  // namespace evaluation_test

}  // namespace rack::mcl_eval
