#include "components/pilot/joystick_drive.h"

#include <gtest/gtest.h>

namespace rack::pilot {
namespace {

ChassisParamData chassis() {
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
  const Drive drive = joystick_drive(stick(50, 100), settings(false), chassis(), nullptr);
  EXPECT_EQ(drive.speed, 400);
  EXPECT_FLOAT_EQ(drive.omega, 0.4F);
  EXPECT_EQ(drive.speed_safe, 800);
  EXPECT_EQ(joystick_drive(stick(0, 100), settings(false), chassis(), nullptr).omega, 0.0F);
  EXPECT_FLOAT_EQ(joystick_drive(stick(-50, 100), settings(false), chassis(), nullptr).omega,
                  -0.4F);
  EXPECT_EQ(joystick_drive(stick(100, 100), settings(false), chassis(), nullptr).speed, 500)
      << "as fast as it can turn";
}

TEST(JoystickDrive, TurnsAtRest) {
  const Drive drive = joystick_drive(stick(0, -50), settings(true), chassis(), nullptr);
  EXPECT_EQ(drive.speed, 0);
  EXPECT_FLOAT_EQ(drive.omega, -0.25F);
}

TEST(JoystickDrive, AStickHasAnEnd) {
  const Drive drive = joystick_drive(stick(1000, -1000), settings(true), chassis(), nullptr);
  EXPECT_EQ(drive.speed, 800);
  EXPECT_FLOAT_EQ(drive.omega, -0.5F);
}

TEST(JoystickDrive, GoesSidewaysWhenItMay) {
  JoystickDriveSettings sideways = settings(true);
  JoystickData pushed = stick(0, 0);
  pushed.position.z = -50;
  EXPECT_EQ(joystick_drive(pushed, sideways, chassis(), nullptr).side, 0);
  sideways.side_speed_max = 300;
  EXPECT_EQ(joystick_drive(pushed, sideways, chassis(), nullptr).side, -150);
}

TEST(JoystickDrive, BrakesUnlessAButtonSaysNo) {
  Scan2dData scan;
  scan.points = {{.x = 300}};
  EXPECT_EQ(joystick_drive(stick(100, 0), settings(true), chassis(), &scan).speed, 300);
  EXPECT_EQ(joystick_drive(stick(100, 0), settings(true), chassis(), &scan).speed_safe, 300);
  EXPECT_EQ(joystick_drive(stick(100, 0, 1), settings(true), chassis(), &scan).speed, 800);
  EXPECT_EQ(joystick_drive(stick(-100, 0), settings(true), chassis(), &scan).speed, -500);
  EXPECT_EQ(joystick_drive(stick(-100, 0), settings(true), chassis(), &scan).speed_safe, -500);
  EXPECT_EQ(joystick_drive(stick(0, 0), settings(true), chassis(), &scan).speed_safe, 300);
}

TEST(JoystickDrive, KeepsTheCurveWhenItBrakes) {
  Scan2dData scan;
  scan.points = {{.x = 200}};
  const Drive drive = joystick_drive(stick(100, 100), settings(true), chassis(), &scan);
  EXPECT_EQ(drive.speed, 200);
  EXPECT_FLOAT_EQ(drive.omega, 0.125F) << "a quarter of the speed, a quarter of the turning speed";
  scan.points = {{.x = 0}};
  EXPECT_EQ(joystick_drive(stick(100, 100), settings(true), chassis(), &scan).omega, 0.0F);
  EXPECT_EQ(joystick_drive(stick(0, 100), settings(true), chassis(), &scan).omega, 0.5F);
}

TEST(JoystickDrive, TheLargerTurningRadiusCounts) {
  ChassisParamData wide = chassis();
  wide.minTurningRadius = 2000;
  EXPECT_FLOAT_EQ(joystick_drive(stick(50, 100), settings(false), wide, nullptr).omega, 0.2F);
  wide.minTurningRadius = 500;
  EXPECT_FLOAT_EQ(joystick_drive(stick(50, 100), settings(false), wide, nullptr).omega, 0.4F);
}

TEST(JoystickDrive, BrakesSideways) {
  JoystickDriveSettings sideways = settings(true);
  sideways.side_speed_max = 300;
  ChassisParamData swerving = chassis();
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
  EXPECT_EQ(joystick_drive(stick(100, 0), fine, chassis(), nullptr).speed, 800);
  EXPECT_EQ(joystick_drive(stick(50, 0), fine, chassis(), nullptr).speed, 331);
  EXPECT_EQ(joystick_drive(stick(-50, 0), fine, chassis(), nullptr).speed, -331);
}

TEST(JoystickDrive, IsDescribedAsAStraightWay) {
  PilotData data;
  describe({.speed = -200, .speed_safe = -200, .omega = 0.1F, .wish = -700}, data);
  EXPECT_EQ(data.speed, -200);
  EXPECT_FLOAT_EQ(data.curve, -0.0005F);
  ASSERT_EQ(data.splines.size(), 1U);
  EXPECT_EQ(data.splines[0].length, -700) << "as far as the stick says";
  EXPECT_EQ(data.splines[0].endPos.x, -700);
  EXPECT_EQ(data.splines[0].vMax, 700);
  EXPECT_EQ(data.splines[0].radius, 0);
  describe({}, data);
  EXPECT_EQ(data.curve, 0.0F);
}

}  // namespace
}  // namespace rack::pilot
