#include "components/world/core/models.h"

#include <limits>

#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack::sim {

namespace models_test {

using namespace std::chrono_literals;

ChassisParamData limits() {
  ChassisParamData limits;
  limits.vxMax = 700;
  limits.vxMin = 50;
  limits.accMax = 500;
  limits.decMax = 1000;
  limits.omegaMax = 0.5F;
  return limits;
}

float speed_after(i32 target) {
  ChassisModel model(limits(), false);
  model.move({.vx = target});
  return model.step(0, 100ms).vx;
}

TEST(ChassisModel, StandsAtFirst) {
  ChassisModel model(limits(), false);
  const ChassisData data = model.step(1234, 100ms);
  EXPECT_EQ(data.recordingTime, TimeStamp(1234));
  EXPECT_EQ(data.vx, 0.0F);
  EXPECT_EQ(data.activePilot, kNoPilot);
}

TEST(ChassisModel, KeepsToItsLimits) {
  EXPECT_EQ(speed_after(0), 0.0F);
  EXPECT_EQ(speed_after(1), 50.0F);
  EXPECT_EQ(speed_after(-1), -50.0F);
  EXPECT_EQ(speed_after(50), 50.0F);
  EXPECT_EQ(speed_after(700), 700.0F);
  EXPECT_EQ(speed_after(701), 700.0F);
  EXPECT_EQ(speed_after(std::numeric_limits<i32>::min()), -700.0F);
  ChassisModel model(limits(), false);
  model.move({.vy = 100, .omega = -3.0F});
  const ChassisData data = model.step(0, 100ms);
  EXPECT_EQ(data.vy, 0.0F) << "it cannot go sideways";
  EXPECT_EQ(data.omega, -0.5F);
  model.move({.omega = std::numeric_limits<f32>::quiet_NaN()});
  EXPECT_EQ(model.step(0, 100ms).omega, 0.0F);
}

TEST(ChassisModel, MovesByItsSpeed) {
  ChassisModel model(limits(), false);
  model.move({.vx = 200, .omega = 0.1F});
  const ChassisData data = model.step(0, 50ms);
  EXPECT_FLOAT_EQ(data.deltaX, 10.0F);
  EXPECT_FLOAT_EQ(data.deltaRho, 0.005F);
}

TEST(ChassisModel, ANewPilotStopsIt) {
  ChassisModel model(limits(), false);
  model.move({.vx = 200});
  model.set_active_pilot(tims::Address(0x00180100));
  const ChassisData data = model.step(0, 50ms);
  EXPECT_EQ(data.vx, 0.0F);
  EXPECT_EQ(data.activePilot, tims::Address(0x00180100));
}

TEST(ChassisModel, AcceleratesAndBrakesWhenWanted) {
  ChassisModel model(limits(), true);
  model.move({.vx = 600});
  EXPECT_FLOAT_EQ(model.step(0, 100ms).vx, 50.0F);
  for (int i = 0; i < 20; ++i) (void)model.step(0, 100ms);
  EXPECT_FLOAT_EQ(model.step(0, 100ms).vx, 600.0F);
  model.move({.vx = 0});
  EXPECT_FLOAT_EQ(model.step(0, 100ms).vx, 500.0F);
  model.move({.vx = -600});
  EXPECT_FLOAT_EQ(model.step(0, 100ms).vx, 400.0F) << "it brakes before it turns round";
}

TEST(ChassisModel, AnAccelerationOf0LimitsNothing) {
  ChassisParamData any = limits();
  any.accMax = 0;
  ChassisModel model(any, true);
  model.move({.vx = 600});
  EXPECT_FLOAT_EQ(model.step(0, 100ms).vx, 600.0F);
  model.move({.vx = 0});
  EXPECT_FLOAT_EQ(model.step(0, 100ms).vx, 500.0F) << "it still brakes as it can";
}

// A wall 2 m north of the origin, from 3 m west to 3 m east.
FloorMap wall() {
  DxfDrawing drawing;
  drawing.lines = {{{-3, 2}, {3, 2}}};
  return {drawing, 1000, 0, 0};
}

TEST(ScanModel, AsALadar) {
  ScanModel model(wall(), {});
  LadarData scan;
  model.measure({.recordingTime = 7}, 100ms, scan);
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
  model.measure({.pos = {.x = 1000}}, 100ms, scan);
  ASSERT_EQ(scan.points.size(), 361U) << "a scan is not added to the last one";
  EXPECT_EQ(scan.points[180].distance, 1000);
}

TEST(ScanModel, WithinItsAngles) {
  ScanModel model(wall(), {.first = -90, .last = 91, .step = 2});
  LadarData scan;
  model.measure({}, 100ms, scan);
  ASSERT_EQ(scan.points.size(), 91U);
  EXPECT_FLOAT_EQ(scan.points[90].angle, static_cast<float>(kPi / 2));
}

TEST(ScanModel, AsPointsOfTheRobot) {
  ScanModel model(wall(), {.max_range = 2500});
  Scan2dData scan;
  // The robot looks east: the wall is on its left.
  model.measure({.pos = {.rho = static_cast<f32>(kPi / 2)}}, 100ms, scan);
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

}  // namespace models_test

}  // namespace rack::sim
