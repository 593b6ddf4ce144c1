#include "components/path/polar_spline.h"

#include <random>

#include <gtest/gtest.h>

namespace rack::path {
namespace polar_spline_test {

constexpr double kRounding = 1.5;  // mm

void expect_near(const Pose& a, const Pose& b, double mm = kRounding) {
  EXPECT_NEAR(a.x, b.x, mm);
  EXPECT_NEAR(a.y, b.y, mm);
  EXPECT_NEAR(signed_angle(a.rho - b.rho), 0, 0.002);
}

TEST(PolarSpline, GoesAlongALine) {
  const auto spline = line({.x = 1000, .y = 2000, .rho = kPi / 2}, 3000);
  EXPECT_EQ(spline.endPos.x, 1000);
  EXPECT_EQ(spline.endPos.y, 5000);
  EXPECT_EQ(spline.radius, 0);
  const auto seen = beside(spline, {.x = 900, .y = 2500, .rho = kPi / 2 + 0.1});
  EXPECT_NEAR(seen.along, 500, kRounding);
  EXPECT_NEAR(seen.across, 100, kRounding) << "facing east, south is to the right";
  EXPECT_NEAR(seen.turned, 0.1, 1e-6);
}

TEST(PolarSpline, TurnsToTheRightAboutACentreOnTheRight) {
  const auto spline = arc({.rho = 0}, 1000, 1000 * kPi / 2);
  EXPECT_EQ(spline.centerPos.x, 0);
  EXPECT_EQ(spline.centerPos.y, 1000);
  expect_near(Pose::of(spline.endPos), {.x = 1000, .y = 1000, .rho = kPi / 2});
}

TEST(PolarSpline, GoesBackwardWithItsHeading) {
  const auto back = arc({.rho = 0}, 1000, -1000 * kPi / 2);
  expect_near(pose_at(back, back.length), {.x = -1000, .y = 1000, .rho = -kPi / 2});
  const auto left = arc({.rho = 0}, -1000, -1000 * kPi / 2);
  expect_near(pose_at(left, left.length), {.x = -1000, .y = -1000, .rho = kPi / 2});
}

// The original's programs measure the angle along an arc in this frame: 0 at the start, growing.
TEST(PolarSpline, HasTheFrameThatTheOriginalMeasuresIn) {
  for (const i32 radius : {2000, -2000}) {
    for (const double distance : {1500.0, -1500.0}) {
      const auto spline = arc({.x = 300, .y = -700, .rho = 0.7}, radius, distance);
      const Pose at = pose_at(spline, distance / 2);
      const Pose center{.x = static_cast<double>(spline.centerPos.x),
                        .y = static_cast<double>(spline.centerPos.y),
                        .rho = static_cast<double>(spline.centerPos.rho)};
      const Pose seen = at - center;
      const double side = radius > 0 ? 1 : -1;
      const double sign = distance > 0 ? 1 : -1;
      EXPECT_NEAR(heading(sign * side * std::atan2(seen.y, seen.x)), 750.0 / 2000, 0.002);
    }
  }
}

TEST(PolarSpline, KnowsWhatIsBesideIt) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 20000; ++i) {
    const Pose from{.x = any(random) * 1e8, .y = any(random) * 1e8, .rho = any(random) * 4};
    const double radius = std::copysign(500 + std::abs(any(random)) * 20000, any(random));
    const double opening = 0.05 + std::abs(any(random)) * 4;
    const double length = std::copysign(opening * std::abs(radius), any(random));
    const bool straight = any(random) < 0;
    const auto spline = straight ? line(from, length) : arc(from, static_cast<i32>(radius), length);
    const double along = std::abs(any(random)) * length;
    const double across = any(random) * 400;
    Pose at = pose_at(spline, along);
    at.x -= across * std::sin(at.rho);
    at.y += across * std::cos(at.rho);
    at.rho += 0.3;
    const auto seen = beside(spline, at);
    EXPECT_NEAR(seen.along, along, 2.5) << i;
    EXPECT_NEAR(seen.across, across, 2.5) << i;
    EXPECT_NEAR(seen.turned, 0.3, 0.006) << i;
  }
}

TEST(PolarSpline, IsFastWhereItMay) {
  PolarSpline spline = line({}, 10000);
  spline.vMax = 1000;
  spline.accMax = spline.decMax = 500;
  EXPECT_EQ(speed_at(spline, 0), 0);
  EXPECT_NEAR(speed_at(spline, 100), 316, 1);
  EXPECT_EQ(speed_at(spline, 5000), 1000);
  EXPECT_NEAR(speed_at(spline, 9900), 316, 1);
  EXPECT_EQ(speed_at(spline, 20000), 0);
}

}  // namespace polar_spline_test
}  // namespace rack::path
