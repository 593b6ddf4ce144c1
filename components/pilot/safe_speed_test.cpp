#include "components/pilot/safe_speed.h"

#include <cmath>

#include <gtest/gtest.h>

namespace rack::pilot {
namespace {

ChassisParamData chassis() {
  ChassisParamData chassis;
  chassis.vxMax = 1000;
  chassis.vxMin = 50;
  chassis.omegaMax = 0.5F;
  chassis.breakConstant = 2;
  chassis.safetyMargin = 50;
  chassis.safetyMarginMove = 200;
  chassis.boundaryFront = 250;
  chassis.boundaryBack = 350;
  chassis.boundaryLeft = 240;
  chassis.boundaryRight = 260;
  return chassis;
}

i32 ahead(i32 x, i32 y, i32 type = 0, Direction direction = Direction::kForward) {
  Scan2dData scan;
  scan.points = {{.x = x, .y = y, .type = type}};
  return safe_speed(direction, chassis(), scan);
}

TEST(SafeSpeed, WithNothingInSight) {
  EXPECT_EQ(safe_speed(Direction::kForward, chassis(), {}), 1000);
  EXPECT_EQ(safe_speed(Direction::kBackward, chassis(), {}), 500);
}

TEST(SafeSpeed, StopsBeforeWhatIsAhead) {
  EXPECT_EQ(ahead(3000, 0), 1000);
  EXPECT_EQ(ahead(1500, 0), 500) << "1000 mm beyond the box";
  EXPECT_EQ(ahead(510, 0), 50) << "the smallest there is";
  EXPECT_EQ(ahead(500, 0), 0);
  EXPECT_EQ(ahead(0, 0), 0);
  EXPECT_EQ(ahead(-400, 0), 1000) << "behind";
}

TEST(SafeSpeed, PassesByWhatIsBesides) {
  EXPECT_EQ(ahead(0, 310), 0);
  EXPECT_EQ(ahead(100, 410), 200);
  EXPECT_EQ(ahead(100, -390), 200);
  EXPECT_EQ(ahead(1500, 410), 500) << "the larger of both";
}

TEST(SafeSpeed, MindsWhatIsBesidesItsWholeLength) {
  EXPECT_EQ(ahead(-100, 340), 60) << "beside the rear hull";
  EXPECT_EQ(ahead(-350, 300), 0);
  EXPECT_EQ(ahead(-351, 300), 1000) << "behind it";
  EXPECT_EQ(ahead(250, -290, 0, Direction::kBackward), 0);
  EXPECT_EQ(ahead(251, -290, 0, Direction::kBackward), 500);
}

TEST(SafeSpeed, Sideways) {
  const auto besides = [](Direction direction, i32 x, i32 y) {
    ChassisParamData sideways = chassis();
    sideways.vyMax = 400;
    sideways.vyMin = 30;
    Scan2dData scan;
    scan.points = {{.x = x, .y = y}};
    return safe_speed(direction, sideways, scan);
  };
  EXPECT_EQ(besides(Direction::kRight, 0, 1010), 250) << "500 mm beyond the box";
  EXPECT_EQ(besides(Direction::kRight, 0, 511), 30) << "the smallest there is";
  EXPECT_EQ(besides(Direction::kRight, 0, 510), 0);
  EXPECT_EQ(besides(Direction::kRight, 0, -241), 400) << "it goes away";
  EXPECT_EQ(besides(Direction::kRight, 400, 300), 200) << "it passes by";
  EXPECT_EQ(besides(Direction::kLeft, 0, -790), 150);
  EXPECT_EQ(besides(Direction::kLeft, -400, 0), 0);
  EXPECT_EQ(besides(Direction::kLeft, 0, 261), 400);
}

TEST(SafeSpeed, Backward) {
  EXPECT_EQ(ahead(-1200, 0, 0, Direction::kBackward), 300);
  EXPECT_EQ(ahead(-600, 0, 0, Direction::kBackward), 0);
  EXPECT_EQ(ahead(600, 0, 0, Direction::kBackward), 500);
}

TEST(SafeSpeed, KindsOfPoints) {
  EXPECT_EQ(ahead(100, 0, scan_point::kInvalid), 1000);
  EXPECT_EQ(ahead(100, 0, 1), 1000) << "a landmark";
  EXPECT_EQ(ahead(100, 0, 2), 0);
  EXPECT_EQ(ahead(1100, 0, 3), 100) << "it moves";
  EXPECT_EQ(ahead(100, 0, scan_point::kReflector), 0);
}

TEST(SafeSpeed, TheSlowestCounts) {
  Scan2dData scan;
  scan.points = {{.x = 3000}, {.x = 700}, {.x = 1500}};
  EXPECT_EQ(safe_speed(Direction::kForward, chassis(), scan), 100);
}

TEST(SafeSpeed, InCurves) {
  EXPECT_DOUBLE_EQ(speed_for_curve(0.001, chassis()), 500);
  EXPECT_DOUBLE_EQ(speed_for_curve(-0.001, chassis()), 500);
  EXPECT_TRUE(std::isinf(speed_for_curve(0, chassis())));
}

}  // namespace
}  // namespace rack::pilot
