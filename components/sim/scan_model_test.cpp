#include "components/sim/scan_model.h"

#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack::sim {
namespace {

using namespace std::chrono_literals;

// A wall 2 m north of the origin, from 3 m west to 3 m east.
FloorMap wall() {
  DxfDrawing drawing;
  drawing.lines = {{{-3, 2}, {3, 2}}};
  return {drawing, 1000, 0, 0};
}

TEST(ScanModel, AsALadar) {
  ScanModel model(wall(), {});
  LadarData scan;
  model.see({.recordingTime = 7}, 100ms, scan);
  EXPECT_EQ(scan.recordingTime, TimeStamp(7));
  EXPECT_EQ(scan.duration, 100U);
  EXPECT_EQ(scan.maxRange, 10000);
  EXPECT_FLOAT_EQ(scan.startAngle, static_cast<float>(-kPi));
  EXPECT_FLOAT_EQ(scan.endAngle, static_cast<float>(kPi));
  ASSERT_EQ(scan.points.size(), 361U);
  EXPECT_EQ(scan.points[180].distance, 2000);
  EXPECT_EQ(scan.points[180].angle, 0.0F);
  EXPECT_EQ(scan.points[180].type, 0);
  EXPECT_EQ(scan.points[0].distance, 10000);
  EXPECT_EQ(scan.points[0].type, ladar_point::kInvalid);
  model.see({.pos = {.x = 1000}}, 100ms, scan);
  ASSERT_EQ(scan.points.size(), 361U) << "a scan is not added to the last one";
  EXPECT_EQ(scan.points[180].distance, 1000);
}

TEST(ScanModel, WithinItsAngles) {
  ScanModel model(wall(), {.first = -90, .last = 91, .step = 2});
  LadarData scan;
  model.see({}, 100ms, scan);
  ASSERT_EQ(scan.points.size(), 91U);
  EXPECT_FLOAT_EQ(scan.points[90].angle, static_cast<float>(kPi / 2));
}

TEST(ScanModel, AsPointsOfTheRobot) {
  ScanModel model(wall(), {.max_range = 2500});
  Scan2dData scan;
  // The robot looks east: the wall is on its left.
  model.see({.pos = {.rho = static_cast<f32>(kPi / 2)}}, 100ms, scan);
  ASSERT_EQ(scan.points.size(), 361U);
  EXPECT_EQ(scan.points[90].x, 0);
  EXPECT_EQ(scan.points[90].y, -2000);
  EXPECT_EQ(scan.points[90].z, 2000);
  EXPECT_EQ(scan.points[90].type, 0);
  EXPECT_EQ(scan.points[180].x, 2500);
  EXPECT_EQ(scan.points[180].type, 0x30);
  EXPECT_EQ(scan.sectorNum, 1);
  EXPECT_EQ(scan.refPos.rho, 0.0F);
}

}  // namespace
}  // namespace rack::sim
