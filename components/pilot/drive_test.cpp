#include "components/pilot/drive.h"

#include <cmath>

#include <gtest/gtest.h>

namespace rack::pilot {

namespace drive_test {

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

TEST(SafeSpeed, RespectsObstaclesBesideItsWholeLength) {
  EXPECT_EQ(ahead(-100, 340), 60) << "beside the rear hull";
  EXPECT_EQ(ahead(-350, 300), 0);
  EXPECT_EQ(ahead(-351, 300), 1000) << "behind it";
  EXPECT_EQ(ahead(250, -290, 0, Direction::kBackward), 0);
  EXPECT_EQ(ahead(251, -290, 0, Direction::kBackward), 500);
}

TEST(SafeSpeed, Sideways) {
  const auto lateral = [](Direction direction, i32 x, i32 y) {
    ChassisParamData sideways = chassis();
    sideways.vyMax = 400;
    sideways.vyMin = 30;
    Scan2dData scan;
    scan.points = {{.x = x, .y = y}};
    return safe_speed(direction, sideways, scan);
  };
  EXPECT_EQ(lateral(Direction::kRight, 0, 1010), 250) << "500 mm beyond the box";
  EXPECT_EQ(lateral(Direction::kRight, 0, 511), 30) << "the smallest there is";
  EXPECT_EQ(lateral(Direction::kRight, 0, 510), 0);
  EXPECT_EQ(lateral(Direction::kRight, 0, -241), 400) << "it goes away";
  EXPECT_EQ(lateral(Direction::kRight, 400, 300), 200) << "it passes by";
  EXPECT_EQ(lateral(Direction::kLeft, 0, -790), 150);
  EXPECT_EQ(lateral(Direction::kLeft, -400, 0), 0);
  EXPECT_EQ(lateral(Direction::kLeft, 0, 261), 400);
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

ChassisParamData agile_chassis() {
  ChassisParamData chassis;
  chassis.vxMax = 1000;
  chassis.vxMin = 50;
  chassis.omegaMax = 0.5F;
  chassis.breakConstant = 1;
  return chassis;
}

JoystickData stick(i32 x, i32 y, i32 buttons = 0) {
  return {.position = {.x = x, .y = y}, .buttons = buttons};
}

JoystickDriveSettings settings(bool turns_at_rest) {
  return {.speed_max = 800, .turns_at_rest = turns_at_rest, .turning_radius_min = 1000};
}

TEST(JoystickDrive, TurnsByCurves) {
  const Drive drive = joystick_drive(stick(50, 100), settings(false), agile_chassis(), nullptr);
  EXPECT_EQ(drive.speed, 400);
  EXPECT_FLOAT_EQ(drive.omega, 0.4F);
  EXPECT_EQ(drive.speed_safe, 1000) << "without a scan: what the vehicle can";
  EXPECT_EQ(joystick_drive(stick(0, 100), settings(false), agile_chassis(), nullptr).omega, 0.0F);
  EXPECT_FLOAT_EQ(joystick_drive(stick(-50, 100), settings(false), agile_chassis(), nullptr).omega,
                  -0.4F);
  EXPECT_EQ(joystick_drive(stick(100, 100), settings(false), agile_chassis(), nullptr).speed, 500)
      << "as fast as it can turn";
}

TEST(JoystickDrive, TurnsAtRest) {
  const Drive drive = joystick_drive(stick(0, -50), settings(true), agile_chassis(), nullptr);
  EXPECT_EQ(drive.speed, 0);
  EXPECT_FLOAT_EQ(drive.omega, -0.25F);
}

TEST(JoystickDrive, AStickHasAnEnd) {
  const Drive drive = joystick_drive(stick(1000, -1000), settings(true), agile_chassis(), nullptr);
  EXPECT_EQ(drive.speed, 800);
  EXPECT_FLOAT_EQ(drive.omega, -0.5F);
}

TEST(JoystickDrive, GoesSidewaysWhenItMay) {
  JoystickDriveSettings sideways = settings(true);
  JoystickData pushed = stick(0, 0);
  pushed.position.z = -50;
  EXPECT_EQ(joystick_drive(pushed, sideways, agile_chassis(), nullptr).side, 0);
  sideways.side_speed_max = 300;
  EXPECT_EQ(joystick_drive(pushed, sideways, agile_chassis(), nullptr).side, -150);
}

TEST(JoystickDrive, BrakesUnlessAButtonIsPressed) {
  Scan2dData scan;
  scan.points = {{.x = 300}};
  EXPECT_EQ(joystick_drive(stick(100, 0), settings(true), agile_chassis(), &scan).speed, 300);
  EXPECT_EQ(joystick_drive(stick(100, 0), settings(true), agile_chassis(), &scan).speed_safe, 300);
  EXPECT_EQ(joystick_drive(stick(100, 0, 1), settings(true), agile_chassis(), &scan).speed, 800);
  EXPECT_EQ(joystick_drive(stick(-100, 0), settings(true), agile_chassis(), &scan).speed, -500);
  EXPECT_EQ(joystick_drive(stick(-100, 0), settings(true), agile_chassis(), &scan).speed_safe,
            -500);
  EXPECT_EQ(joystick_drive(stick(0, 0), settings(true), agile_chassis(), &scan).speed_safe, 300);
}

// Numbers of the original's rules: min(scan, curve, vxMax), twice vxMax with a button.
TEST(JoystickDrive, TheSecondNumberOfMoveIsThatOfTheOriginal) {
  const Scan2dData free;
  const auto second = [](const JoystickData& stick, bool at_rest, const Scan2dData* scan) {
    return joystick_drive(stick, settings(at_rest), agile_chassis(), scan).speed_safe;
  };
  EXPECT_EQ(second(stick(100, 0), true, &free), 1000) << "also above maxSpeed";
  EXPECT_EQ(second(stick(-100, 0), true, &free), -500);
  EXPECT_EQ(second(stick(0, 0), true, &free), 1000);
  EXPECT_EQ(second(stick(100, 100), false, &free), 500) << "0.5 rad/s at a radius of 1 m";
  EXPECT_EQ(second(stick(-100, -100), false, &free), -500);
  EXPECT_EQ(second(stick(100, 100), true, &free), 1000) << "an angular speed is no curve";
  EXPECT_EQ(second(stick(100, 0, 1), true, &free), 2000);
  EXPECT_EQ(second(stick(-100, 0, 2), true, &free), -2000);
  EXPECT_EQ(second(stick(-100, 0, 1), true, nullptr), 1000) << "forward without a scan";
  Scan2dData near;
  near.points = {{.x = 300}};
  EXPECT_EQ(second(stick(10, 0), true, &near), 300);
  ChassisParamData fastest = agile_chassis();
  fastest.vxMax = 0x7FFFFFFF;
  EXPECT_EQ(joystick_drive(stick(100, 0, 1), settings(true), fastest, &free).speed_safe,
            0x7FFFFFFF);
}

TEST(JoystickDrive, KeepsTheCurveWhenItBrakes) {
  Scan2dData scan;
  scan.points = {{.x = 200}};
  const Drive drive = joystick_drive(stick(100, 100), settings(true), agile_chassis(), &scan);
  EXPECT_EQ(drive.speed, 200);
  EXPECT_FLOAT_EQ(drive.omega, 0.125F) << "a quarter of the speed, a quarter of the turning speed";
  scan.points = {{.x = 0}};
  EXPECT_EQ(joystick_drive(stick(100, 100), settings(true), agile_chassis(), &scan).omega, 0.0F);
  EXPECT_EQ(joystick_drive(stick(0, 100), settings(true), agile_chassis(), &scan).omega, 0.5F);
}

TEST(JoystickDrive, TheLargerTurningRadiusCounts) {
  ChassisParamData wide = agile_chassis();
  wide.minTurningRadius = 2000;
  EXPECT_FLOAT_EQ(joystick_drive(stick(50, 100), settings(false), wide, nullptr).omega, 0.2F);
  wide.minTurningRadius = 500;
  EXPECT_FLOAT_EQ(joystick_drive(stick(50, 100), settings(false), wide, nullptr).omega, 0.4F);
}

TEST(JoystickDrive, BrakesSideways) {
  JoystickDriveSettings sideways = settings(true);
  sideways.side_speed_max = 300;
  ChassisParamData swerving = agile_chassis();
  swerving.vyMax = 400;
  JoystickData pushed = stick(0, 0);
  pushed.position.z = 100;
  Scan2dData scan;
  scan.points = {{.x = 0, .y = 120}};
  EXPECT_EQ(joystick_drive(pushed, sideways, swerving, &scan).side, 120);
  pushed.position.z = -100;
  EXPECT_EQ(joystick_drive(pushed, sideways, swerving, &scan).side, -300);
  pushed.position.z = 100;
  pushed.buttons = 1;
  EXPECT_EQ(joystick_drive(pushed, sideways, swerving, &scan).side, 300);
}

TEST(JoystickDrive, BendsTheCurveOfTheStick) {
  JoystickDriveSettings fine = settings(true);
  fine.x_exponent = 1;
  EXPECT_EQ(joystick_drive(stick(100, 0), fine, agile_chassis(), nullptr).speed, 800);
  EXPECT_EQ(joystick_drive(stick(50, 0), fine, agile_chassis(), nullptr).speed, 331);
  EXPECT_EQ(joystick_drive(stick(-50, 0), fine, agile_chassis(), nullptr).speed, -331);
}

TEST(JoystickDrive, IsDescribedAsAStraightPath) {
  PilotData data;
  ChassisParamData chassis = agile_chassis();
  chassis.accMax = 400;
  chassis.decMax = 600;
  describe({.speed = -200, .speed_safe = -200, .omega = 0.1F, .target = -700}, chassis, data);
  EXPECT_EQ(data.speed, -200);
  EXPECT_FLOAT_EQ(data.curve, -0.0005F);
  ASSERT_EQ(data.splines.size(), 1U);
  EXPECT_EQ(data.splines[0].length, -700) << "as far as the stick requests";
  EXPECT_EQ(data.splines[0].endPos.x, -700);
  EXPECT_EQ(data.splines[0].vMax, -700) << "signed, as by the original";
  EXPECT_EQ(data.splines[0].vStart, -700);
  EXPECT_EQ(data.splines[0].vEnd, -700);
  EXPECT_EQ(data.splines[0].accMax, 400);
  EXPECT_EQ(data.splines[0].decMax, 600);
  EXPECT_EQ(data.splines[0].basepoint.x, 0);
  EXPECT_EQ(data.splines[0].basepoint.speed, 0);
  EXPECT_EQ(data.splines[0].radius, 0);
  describe({}, chassis, data);
  EXPECT_EQ(data.curve, 0.0F);
}

}  // namespace drive_test

}  // namespace rack::pilot
