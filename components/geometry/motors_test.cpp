#include "components/geometry/motors.h"

#include <gtest/gtest.h>

namespace rack::device {
namespace motors_test {

TEST(MotorMotion, GainsSpeedAndBrakesWithinItsLimits) {
  constexpr Acceleration<double> kLimit{.faster = 100, .slower = 400};
  MotorMotion motor;
  motor.run(300, kLimit, 0.5);
  EXPECT_EQ(motor.speed, 50);
  EXPECT_EQ(motor.position, 25);
  motor.run(300, kLimit, 10);
  EXPECT_EQ(motor.speed, 300) << "not above its target";
  motor.run(-300, kLimit, 0.5);
  EXPECT_EQ(motor.speed, 100) << "it brakes before it turns round";
  motor.run(-300, {}, 0.5);
  EXPECT_EQ(motor.speed, -300) << "0 is no limit";
}

TEST(MotorMotion, GoesToAPlaceAtItsSpeed) {
  MotorMotion motor;
  motor.go_to(-3, 4, 0.5);
  EXPECT_EQ(motor.position, -2);
  EXPECT_EQ(motor.speed, -4);
  motor.go_to(-3, 4, 0.5);
  EXPECT_EQ(motor.position, -3);
  EXPECT_EQ(motor.speed, -2);
  motor.go_to(7, 0, 0.5);
  EXPECT_EQ(motor.position, 7) << "0 is no limit";
}

}  // namespace motors_test
}  // namespace rack::device
