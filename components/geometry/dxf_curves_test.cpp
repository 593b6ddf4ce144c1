#include "components/geometry/dxf_curves.h"

#include <cmath>

#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack {

namespace dxf_curves_test {

double off(const DxfPoint& a, double x, double y) { return std::hypot(a.x - x, a.y - y); }

TEST(DxfCurves, ACircleHas72Chords) {
  const auto points = chords(dxf_circle({10, 20}, 2), 0, 2 * kPi);
  ASSERT_EQ(points.size(), 73U);
  EXPECT_LT(off(points.front(), 12, 20), 1e-12);
  EXPECT_LT(off(points.back(), 12, 20), 1e-12);
  EXPECT_LT(off(points[18], 10, 22), 1e-12);
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double middle =
        off({(points[i].x + points[i - 1].x) / 2, (points[i].y + points[i - 1].y) / 2}, 10, 20);
    EXPECT_GT(middle, 2 * (1 - 0.001)) << "a chord is within a thousandth of the radius";
  }
}

TEST(DxfCurves, AnglesRunCounterClockwise) {
  EXPECT_NEAR(dxf_sweep(radians(350), radians(10)), radians(20), 1e-12);
  EXPECT_NEAR(dxf_sweep(radians(10), radians(350)), radians(340), 1e-12);
  EXPECT_NEAR(dxf_sweep(0, 2 * kPi), 2 * kPi, 1e-12);
  EXPECT_NEAR(dxf_sweep(1, 1), 2 * kPi, 1e-12);
  EXPECT_NEAR(dxf_sweep(radians(-720), radians(90)), radians(90), 1e-9);
  for (const double angle : {1e9, -1e9, 1.7e7}) {
    EXPECT_GT(dxf_sweep(0, angle), 0);
    EXPECT_LE(dxf_sweep(angle, 0), 2 * kPi + 1e-8);
  }
}

TEST(DxfCurves, AnEllipseHasTwoAxes) {
  const auto points = chords({{0, 0}, {0, 4}, {-1, 0}}, 0, kPi / 2);
  ASSERT_EQ(points.size(), 19U);
  EXPECT_LT(off(points.front(), 0, 4), 1e-12);
  EXPECT_LT(off(points.back(), -1, 0), 1e-12);
}

// AutoCAD: a bulge of 1 is a half circle to the right of the segment, a negative one to the left.
TEST(DxfCurves, ABulgeIsAnArc) {
  std::vector<DxfPoint> points;
  add_bulge({0, 0}, {2, 0}, 1, points);
  ASSERT_EQ(points.size(), 36U);
  EXPECT_LT(off(points[17], 1, -1), 1e-12);
  EXPECT_LT(off(points.back(), 2, 0), 1e-12);
  points.clear();
  add_bulge({0, 0}, {2, 0}, -1, points);
  EXPECT_LT(off(points[17], 1, 1), 1e-12);
  points.clear();
  add_bulge({1, 0}, {0, 1}, std::tan(kPi / 8), points);  // a quarter around 0, 0
  ASSERT_EQ(points.size(), 18U);
  for (const DxfPoint& point : points) EXPECT_NEAR(std::hypot(point.x, point.y), 1, 1e-12);
}

TEST(DxfCurves, APolylineIsClosedAtItsFirstPoint) {
  std::vector<DxfPoint> points = {{0, 0}, {2, 0}};
  points.shrink_to_fit();
  add_bulge(points.back(), points.front(), 1, points);
  EXPECT_EQ(points.back().x, 0);
  EXPECT_EQ(points.size(), 38U);
}

TEST(DxfCurves, HardlyABulgeIsALine) {
  for (const double bulge : {0.0, 1e-300, -1e-9, 0.02}) {
    std::vector<DxfPoint> points;
    add_bulge({0, 0}, {1, 1}, bulge, points);
    EXPECT_EQ(points.size(), 1U) << bulge;
  }
  std::vector<DxfPoint> points;
  add_bulge({0, 0}, {0, 0}, 1e9, points);
  for (const DxfPoint& point : points) EXPECT_TRUE(std::isfinite(point.x + point.y));
}

}  // namespace dxf_curves_test

}  // namespace rack
