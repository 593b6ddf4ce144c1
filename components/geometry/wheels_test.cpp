#include "components/geometry/wheels.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

namespace rack::device {
namespace wheels_test {

void expect_round_trip(const Wheels& wheels, const ChassisSpeed& speed) {
  std::array<double, 6> motors{};
  wheels.targets(speed, motors);
  const ChassisSpeed back = wheels.movement(motors);
  EXPECT_NEAR(back.vx, speed.vx, 0.5 + std::abs(speed.vx) * 0.002);
  EXPECT_NEAR(back.vy, speed.vy, 0.5 + std::abs(speed.vx) * 0.002);
  EXPECT_NEAR(back.omega, speed.omega, 0.004);
}

TEST(WheelsTest, TheLeftWheelIsFasterInARightTurn) {
  std::array<double, 2> motors{};
  Wheels::differential(400).targets({.vx = 300, .omega = 0.5F}, motors);
  EXPECT_NEAR(motors[0], 400, 1e-3);
  EXPECT_NEAR(motors[1], 200, 1e-3);
}

TEST(WheelsTest, ASteeredAxlePointsAcrossTheCentreOfTheTurn) {
  // 2 m before an axle that turns around a point 4 m to its right.
  std::array<double, 3> motors{};
  const auto wheels = Wheels::ackermann(2000, 1000, false, 1);
  wheels.targets({.vx = 1000, .omega = 0.25F}, motors);
  EXPECT_NEAR(motors[2], std::atan(0.5), 1e-6);
  EXPECT_NEAR(motors[0], 1125, 1e-3);
  EXPECT_NEAR(motors[1], 875, 1e-3);
  wheels.targets({.vx = -1000, .omega = -0.25F}, motors);
  EXPECT_NEAR(motors[2], std::atan(0.5), 1e-6);  // the same curve backwards
  EXPECT_NEAR(motors[0], -1125, 1e-3);
  EXPECT_TRUE(wheels.is_steering(2));
  EXPECT_FALSE(wheels.is_steering(1));
}

TEST(WheelsTest, SteeringStaysWhereItWasWhenTheVehicleStands) {
  std::array<double, 2> motors{0, 0.3};
  Wheels::ackermann(2000, 1000, true, 1).targets({}, motors);
  EXPECT_EQ(motors[0], 0);
  EXPECT_EQ(motors[1], 0.3);
}

TEST(WheelsTest, BothAxlesOfARobucarSteerAgainstEachOtherOrTogether) {
  const auto wheels = Wheels::double_ackermann(1200, 1000, 0.35);
  std::array<double, 6> motors{};
  wheels.targets({.vx = 1000, .omega = 0.25F}, motors);
  EXPECT_NEAR(motors[4], std::atan(0.15), 1e-6);
  EXPECT_NEAR(motors[5], -std::atan(0.15), 1e-6);
  wheels.targets({.vx = 1000, .vy = 200}, motors);
  EXPECT_NEAR(motors[4], std::atan(0.2), 1e-6);
  EXPECT_NEAR(motors[5], std::atan(0.2), 1e-6);
  wheels.targets({.vx = 100, .omega = 2}, motors);
  EXPECT_EQ(motors[4], 0.35);
}

TEST(WheelsTest, TargetsAndMovementAreInverse) {
  for (const float vx : {-2000.0F, -100.0F, 50.0F, 4000.0F}) {
    for (const float curve : {-0.0002F, 0.0F, 0.0001F}) {
      const ChassisSpeed speed{.vx = vx, .omega = vx * curve};
      expect_round_trip(Wheels::differential(400), speed);
      expect_round_trip(Wheels::ackermann(2000, 1000, true, 1), speed);
      expect_round_trip(Wheels::ackermann(2000, 1000, false, 1), speed);
      expect_round_trip(Wheels::double_ackermann(1200, 1000, 1), speed);
      expect_round_trip(Wheels::double_ackermann(1200, 1000, 1), {.vx = vx, .vy = vx / 10});
    }
  }
}

}  // namespace wheels_test
}  // namespace rack::device
