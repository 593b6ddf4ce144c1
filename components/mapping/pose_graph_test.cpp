#include "components/mapping/pose_graph.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "components/geometry/random.h"

namespace rack::mapping {

namespace pose_graph_test {

Information sure(double distance, double turn) {
  Information information = Information::Zero();
  information.diagonal() << 1 / (distance * distance), 1 / (distance * distance), 1 / (turn * turn);
  return information;
}

// Round a circle of 40 poses, with steps that err, and back to the first one.
struct Circle {
  std::vector<Pose> truth;
  std::vector<Edge> edges;
  std::vector<Pose> poses;

  explicit Circle(std::uint64_t seed) {
    Random random(seed);
    const auto normal = [&] { return static_cast<double>(random.normal()); };
    for (int i = 0; i < 40; ++i) {
      const double part = i * kPi / 20;
      truth.push_back(
          {.x = 5000 * std::sin(part), .y = 5000 * (1 - std::cos(part)), .rho = heading(part)});
    }
    poses.push_back(truth.front());
    for (std::size_t i = 1; i < truth.size(); ++i) {
      Pose step = truth[i] - truth[i - 1];
      step.x += 20 * normal();
      step.y += 20 * normal();
      step.rho += 0.02 * normal();
      edges.push_back({i - 1, i, step, sure(20, 0.02)});
      poses.push_back(poses.back() + step);
    }
  }
  void close() { edges.push_back({0, 39, truth[39] - truth[0], sure(5, 0.002)}); }
  [[nodiscard]] double off() const {
    double most = 0;
    for (std::size_t i = 0; i < truth.size(); ++i)
      most = std::max(most, std::hypot(poses[i].x - truth[i].x, poses[i].y - truth[i].y));
    return most;
  }
};

TEST(PoseGraph, AClosedLoopMakesAllPosesBetter) {
  double before = 0;
  double after = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Circle circle(seed);
    before += circle.off();
    circle.close();
    ASSERT_TRUE(optimise(circle.edges, circle.poses, Doubt::kNotAtFirst));
    after += circle.off();
    EXPECT_LT(disagreement(circle.edges.back(), circle.poses), 9);
    EXPECT_NEAR(circle.poses[0].x, circle.truth[0].x, 1e-9);
  }
  EXPECT_LT(after, before / 2);
}

TEST(PoseGraph, AWrongEdgeAmongManyDoesNotBendTheMap) {
  Circle circle(3);
  for (std::size_t i = 0; i + 5 < circle.truth.size(); ++i)
    circle.edges.push_back({i, i + 5, circle.truth[i + 5] - circle.truth[i], sure(5, 0.002)});
  circle.close();
  auto wrong = circle;
  wrong.edges.push_back({10, 30, {.x = 100, .y = 100}, sure(5, 0.002)});
  ASSERT_TRUE(optimise(circle.edges, circle.poses, Doubt::kNotAtFirst));
  ASSERT_TRUE(optimise(wrong.edges, wrong.poses, Doubt::kNotAtFirst));
  EXPECT_LT(circle.off(), 30);
  EXPECT_LT(wrong.off(), 40);
}

TEST(PoseGraph, SurvivesGraphsThatAreNone) {
  std::vector<Pose> poses;
  EXPECT_TRUE(optimise({}, poses, Doubt::kAlways));
  poses = {{.x = 1}, {.x = 2}};
  EXPECT_TRUE(optimise({}, poses, Doubt::kAlways));
  const std::vector<Edge> broken{{0, 1, {.x = std::nan("")}, sure(1, 1)}};
  EXPECT_FALSE(optimise(broken, poses, Doubt::kAlways));
  EXPECT_EQ(poses[1].x, 2) << "and they are as before";
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// A chain bends, and nothing contradicts it; a loop leaves little room.
TEST(PoseGraph, SpreadIsSmallWhereALoopIsClosed) {
  Circle circle(1);
  const double open = mean(spread(circle.edges, circle.poses));
  EXPECT_GT(open, 50);
  EXPECT_LT(open, 1000);
  circle.close();
  ASSERT_TRUE(optimise(circle.edges, circle.poses, Doubt::kNotAtFirst));
  EXPECT_LT(mean(spread(circle.edges, circle.poses)), 0.6 * open);
}

TEST(PoseGraph, SpreadIsAsLargeAsTheErrorsThatAreMade) {
  double made = 0;
  double expected = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Circle circle(seed);
    // The frame of the truth is that of the first pose, the spread has the best one: less.
    const std::vector<double> deviations = spread(circle.edges, circle.poses);
    made += circle.off() / 20;
    expected += *std::ranges::max_element(deviations) / 20;
  }
  EXPECT_LT(expected, made);
  EXPECT_GT(expected, 0.2 * made);
}

TEST(PoseGraph, SpreadOfNothingIsNothing) {
  EXPECT_TRUE(spread({}, {}).empty());
  const std::vector<Pose> one(1);
  EXPECT_TRUE(spread({}, one).empty());
}

}  // namespace pose_graph_test

}  // namespace rack::mapping
