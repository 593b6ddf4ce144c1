#include "components/scan2d/ladar_scan.h"

#include <limits>

#include <gtest/gtest.h>

#include "components/geometry/angle.h"

namespace rack::scan2d {
namespace {

LadarPoint point(double degrees, i32 distance, i32 type = 0) {
  return {.angle = static_cast<f32>(radians(degrees)), .distance = distance, .type = type};
}

Scan2dData converted(const std::vector<LadarPoint>& points, const LadarMounting& mounting = {},
                     const ScanFilter& filter = {}) {
  LadarData ladar{.recordingTime = 5, .duration = 20, .maxRange = 20000};
  ladar.points.assign(points.begin(), points.end());
  Scan2dData scan;
  convert(ladar, mounting, filter, scan);
  return scan;
}

TEST(LadarScan, BecomesPoints) {
  const Scan2dData scan = converted({point(0, 1000), point(90, 500), point(-90, 2000)});
  EXPECT_EQ(scan.recordingTime, TimeStamp(5));
  EXPECT_EQ(scan.duration, 20U);
  EXPECT_EQ(scan.maxRange, 20000);
  ASSERT_EQ(scan.points.size(), 3U);
  EXPECT_EQ(scan.points[0].x, 1000);
  EXPECT_EQ(scan.points[1].y, 500);
  EXPECT_EQ(scan.points[2].y, -2000);
  EXPECT_EQ(scan.points[2].z, 2000);
}

TEST(LadarScan, WhereTheLadarIs) {
  const Scan2dData scan =
      converted({point(0, 1000), point(90, 500)}, {.x = 100, .y = -20, .rho = radians(90)});
  EXPECT_EQ(scan.points[0].x, 100);
  EXPECT_EQ(scan.points[0].y, 980);
  EXPECT_EQ(scan.points[1].x, -400);
  EXPECT_EQ(converted({point(90, 500)}, {.upside_down = true}).points[0].y, -500);
}

TEST(LadarScan, WhatIsTooFarOrNothing) {
  const Scan2dData scan = converted({point(0, 5000), point(0, 4999), point(0, 0), point(0, -7)}, {},
                                    {.range_max = 5000});
  EXPECT_EQ(scan.maxRange, 5000);
  EXPECT_EQ(scan.points[0].type, 0x30);
  EXPECT_EQ(scan.points[1].type, 0);
  EXPECT_EQ(scan.points[2].type, 0x30);
  EXPECT_EQ(scan.points[2].z, 5000);
  EXPECT_EQ(scan.points[3].type, 0x30);
}

TEST(LadarScan, Types) {
  const Scan2dData scan =
      converted({point(0, 1, ladar_point::kRain), point(0, 1, ladar_point::kDirt),
                 point(0, 1, ladar_point::kTransparent), point(0, 1, ladar_point::kInvalid),
                 point(0, 1, ladar_point::kReflector)});
  for (int i = 0; i < 4; ++i) EXPECT_EQ(scan.points[static_cast<std::size_t>(i)].type, 0x10);
  EXPECT_EQ(scan.points[4].type, 0x80);
}

TEST(LadarScan, ReducedAndCut) {
  std::vector<LadarPoint> points;
  for (int i = -180; i <= 180; ++i) points.push_back(point(i, 1000));
  EXPECT_EQ(converted(points).points.size(), 361U);
  EXPECT_EQ(converted(points, {}, {.reduce = 2}).points.size(), 181U);
  EXPECT_EQ(converted(points, {}, {.angle_min = radians(-90.5), .angle_max = radians(90.5)})
                .points.size(),
            181U);
  points = {point(std::numeric_limits<double>::quiet_NaN(), 1000)};
  EXPECT_TRUE(converted(points).points.empty());
}

TEST(LadarScan, TheMedianTakesOutWhatSticksOut) {
  const std::vector<LadarPoint> points = {point(0, 100), point(1, 9000), point(2, 102),
                                          point(3, 101), point(4, 5)};
  const Scan2dData scan = converted(points, {}, {.median = true});
  EXPECT_EQ(scan.points[0].z, 100);
  EXPECT_EQ(scan.points[1].z, 102);
  EXPECT_EQ(scan.points[2].z, 102);
  EXPECT_EQ(scan.points[3].z, 101);
  EXPECT_EQ(scan.points[4].z, 5) << "the ends have one neighbour only";
}

TEST(LadarScan, AReflectorIsNeverAlone) {
  const i32 kR = ladar_point::kReflector;
  const std::vector<LadarPoint> points = {point(0, 1, kR), point(1, 1), point(2, 1, kR),
                                          point(3, 1, kR)};
  const Scan2dData scan = converted(points, {}, {.reflectors = true});
  EXPECT_EQ(scan.points[0].type, 0);
  EXPECT_EQ(scan.points[2].type, 0x80);
  EXPECT_EQ(scan.points[3].type, 0x80);
}

}  // namespace
}  // namespace rack::scan2d
