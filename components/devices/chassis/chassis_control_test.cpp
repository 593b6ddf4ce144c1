#include "components/devices/chassis/chassis_control.h"

#include <numbers>

#include <gtest/gtest.h>

namespace rack::device {
namespace chassis_control_test {

using namespace std::chrono_literals;

ChassisParamData limits() {
  ChassisParamData limits;
  limits.vxMax = 700;
  limits.vxMin = 50;
  limits.accMax = 0;
  limits.decMax = 0;
  limits.omegaMax = 0.5F;
  limits.minTurningRadius = 2000;
  limits.trackWidth = 400;
  return limits;
}

class ChassisControlTest : public testing::Test {
 protected:
  // Sends MOVEs until the period of the pilot is known.
  void drive(ChassisControl& control, Duration period, int times = 6) {
    for (int i = 0; i < times; ++i) {
      now_ += period;
      control.move({.vx = 300}, now_);
      EXPECT_EQ(control.speed(now_).vx, 300);
    }
  }
  Time now_{1000s};
};

TEST_F(ChassisControlTest, AMoveHoldsThreePeriodsOfItsPilot) {
  for (const Duration period : {20ms, 50ms, 100ms, 250ms}) {
    ChassisControl control(limits(), {});
    drive(control, period);
    EXPECT_EQ(control.deadline(), 3 * period);
    EXPECT_EQ(control.next_change(), now_ + 3 * period);
    EXPECT_EQ(control.speed(now_ + 3 * period - 1ms).vx, 300);
    EXPECT_FALSE(control.take_overdue());
    EXPECT_EQ(control.speed(now_ + 3 * period), ChassisSpeed{});
    EXPECT_TRUE(control.take_overdue());
    EXPECT_FALSE(control.take_overdue());
    EXPECT_EQ(control.next_change(), tims::kNever);
  }
}

TEST_F(ChassisControlTest, AnUnknownPeriodPermitsThreeTenthsOfASecond) {
  ChassisControl control(limits(), {});
  control.move({.vx = 300}, now_);
  EXPECT_EQ(control.speed(now_ + 299ms).vx, 300);
  EXPECT_EQ(control.speed(now_ + 300ms).vx, 0);
}

TEST_F(ChassisControlTest, OneLateMoveAndTwoInARowAreNoPeriod) {
  ChassisControl control(limits(), {});
  drive(control, 50ms);
  now_ += 140ms;
  control.move({.vx = 300}, now_);
  control.move({.vx = 300}, now_ + 1us);
  EXPECT_EQ(control.deadline(), 150ms);
}

TEST_F(ChassisControlTest, APilotSlowerThanASecondIsStopped) {
  ChassisControl control(limits(), {});
  drive(control, 900ms);
  EXPECT_EQ(control.deadline(), 1s);
  EXPECT_EQ(control.speed(now_ + 1s).vx, 0);
}

TEST_F(ChassisControlTest, AStillPilotWasNotTooLate) {
  ChassisControl control(limits(), {});
  control.move({}, now_);
  EXPECT_EQ(control.speed(now_ + 10s), ChassisSpeed{});
  EXPECT_FALSE(control.take_overdue());
}

TEST_F(ChassisControlTest, AnotherPilotBeginsWithStanding) {
  ChassisControl control(limits(), {});
  EXPECT_EQ(control.active_pilot(), kNoPilot);
  control.set_active_pilot(tims::Address(0x180000));
  drive(control, 50ms);
  control.set_active_pilot(tims::Address(0x180100));
  EXPECT_EQ(control.speed(now_), ChassisSpeed{});
  EXPECT_EQ(control.deadline(), 300ms);
}

TEST_F(ChassisControlTest, SpeedsAreCutToTheVehicle) {
  ChassisControl control(limits(), {});
  control.move({.vx = 5000, .vy = 5000, .omega = 9.0F}, now_);
  EXPECT_EQ(control.speed(now_), (ChassisSpeed{700, 0, 0.5F}));
  control.move({.vx = -1, .omega = -9.0F}, now_);
  EXPECT_EQ(control.speed(now_), (ChassisSpeed{-50, 0, -0.5F}));
  control.move({.vx = 0, .omega = std::numeric_limits<float>::quiet_NaN()}, now_);
  EXPECT_EQ(control.speed(now_), ChassisSpeed{});
}

TEST_F(ChassisControlTest, WhatIsSteeredTurnsNoTighterThanItCan) {
  ChassisControl control(limits(), {.turns_on_the_spot = false});
  control.move({.vx = 400, .omega = 0.5F}, now_);
  EXPECT_FLOAT_EQ(control.speed(now_).omega, 0.2F);
  control.move({.vx = -400, .omega = 0.5F}, now_);
  EXPECT_FLOAT_EQ(control.speed(now_).omega, 0.2F);
  control.move({.vx = 0, .omega = 0.5F}, now_);
  EXPECT_EQ(control.speed(now_).omega, 0);
}

TEST_F(ChassisControlTest, SpeedGrowsAndFallsAsItMay) {
  auto slow = limits();
  slow.accMax = 500;
  slow.decMax = 1000;
  ChassisControl control(slow, {.turns_on_the_spot = false, .move_deadline = 10s});
  control.move({.vx = 400, .omega = 0.2F}, now_);
  EXPECT_EQ(control.speed(now_).vx, 0);
  EXPECT_EQ(control.next_change(), now_ + 20ms);
  const auto half = control.speed(now_ + 400ms);
  EXPECT_FLOAT_EQ(half.vx, 200);
  EXPECT_FLOAT_EQ(half.omega, 0.1F);  // on the same curve
  EXPECT_FLOAT_EQ(control.speed(now_ + 800ms).vx, 400);
  control.move({}, now_ + 800ms);
  EXPECT_FLOAT_EQ(control.speed(now_ + 1s).vx, 200);
  EXPECT_FLOAT_EQ(control.speed(now_ + 1200ms).vx, 0);
}

}  // namespace chassis_control_test
}  // namespace rack::device
