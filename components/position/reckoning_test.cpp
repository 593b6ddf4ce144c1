#include "components/position/reckoning.h"

#include <limits>

#include <gtest/gtest.h>

namespace rack::navigation {

namespace reckoning_test {

TEST(DeadReckoning, DrivesAroundABlock) {
  DeadReckoning reckoning({.x = 1000});
  OdometryData data;
  for (int side = 0; side < 4; ++side) {
    for (int i = 0; i < 1000; ++i) data = reckoning.add({.deltaX = 0.4F});
    if (side == 0) {
      EXPECT_EQ(data.pos.x, 1400) << "fractions add up";
    }
    data = reckoning.add({.recordingTime = 7, .deltaRho = static_cast<f32>(kPi / 2)});
  }
  EXPECT_EQ(data.recordingTime, TimeStamp(7));
  EXPECT_EQ(data.pos.x, 1000);
  EXPECT_EQ(data.pos.y, 0);
}

TEST(DeadReckoning, GoesSideways) {
  DeadReckoning reckoning({.rho = kPi / 2});
  const OdometryData data = reckoning.add({.deltaY = 100});
  EXPECT_EQ(data.pos.x, -100);
  EXPECT_EQ(data.pos.y, 0);
}

TEST(DeadReckoning, ResetIsZero) {
  DeadReckoning reckoning({.x = 1000, .rho = 1});
  reckoning.reset();
  const OdometryData data = reckoning.add({});
  EXPECT_EQ(data.pos.x, 0);
  EXPECT_EQ(data.pos.rho, 0.0F);
}

TEST(DeadReckoning, LeavesOutWhatIsNoMovement) {
  DeadReckoning reckoning({});
  (void)reckoning.add({.deltaX = std::numeric_limits<f32>::quiet_NaN()});
  (void)reckoning.add({.deltaRho = std::numeric_limits<f32>::infinity()});
  EXPECT_EQ(reckoning.add({.deltaX = 5}).pos.x, 5);
}

OdometryData at(u32 time, i32 x, double rho) {
  return {.recordingTime = time, .pos = {.x = x, .rho = static_cast<f32>(rho)}};
}

ChassisData movement(u32 time, float x, float speed, float rho = 0, float omega = 0) {
  ChassisData data{.recordingTime = time};
  data.deltaX = x;
  data.deltaRho = rho;
  data.vx = speed;
  data.omega = omega;
  return data;
}

// 100 mm every 200 ms; three of them are lost.
TEST(DeadReckoning, GoesOnOverLostData) {
  DeadReckoning reckoning({});
  reckoning.add(movement(200, 100, 500));
  EXPECT_EQ(reckoning.add(movement(400, 100, 500)).pos.x, 200);
  EXPECT_EQ(reckoning.add(movement(1200, 100, 500)).pos.x, 600);
  EXPECT_EQ(reckoning.add(movement(1400, 100, 500)).pos.x, 700);
}

TEST(DeadReckoning, GoesOnOverALostTurn) {
  DeadReckoning reckoning({});
  reckoning.add(movement(200, 0, 0, 0.1F, 0.5F));
  EXPECT_NEAR(reckoning.add(movement(800, 0, 0, 0.1F, 0.5F)).pos.rho, 0.4, 1e-6);
}

// A driver that was late reports the whole movement at once.
TEST(DeadReckoning, NothingIsLostWhenAMovementTookTheWholeTime) {
  DeadReckoning reckoning({});
  reckoning.add(movement(200, 100, 500));
  EXPECT_EQ(reckoning.add(movement(1200, 500, 500)).pos.x, 600);
}

TEST(DeadReckoning, AGapOfSecondsIsNotEstimated) {
  constexpr auto kLongest = static_cast<u32>(DeadReckoning::kLongestGap.count());
  for (const u32 gap : {kLongest, kLongest + 1}) {
    DeadReckoning reckoning({});
    reckoning.add(movement(200, 100, 500));
    const bool estimates = reckoning.add(movement(200 + gap, 100, 500)).pos.x > 200;
    EXPECT_EQ(estimates, gap <= kLongest) << gap;
  }
}

TEST(Interpolated, BetweenAndBeyond) {
  const OdometryData before = at(1000, 0, radians(350));
  const OdometryData after = at(1100, 200, radians(10));
  EXPECT_EQ(interpolated(before, after, 1000).pos.x, 0);
  EXPECT_EQ(interpolated(before, after, 1050).pos.x, 100);
  EXPECT_NEAR(interpolated(before, after, 1075).pos.rho, radians(5), 1e-6);
  EXPECT_EQ(interpolated(before, after, 1150).pos.x, 300);
  EXPECT_EQ(interpolated(before, after, 1150).recordingTime, TimeStamp(1150));
}

TEST(Interpolated, AcrossTheWrapOfTime) {
  EXPECT_EQ(interpolated(at(0xFFFFFFCE, 0, 0), at(50, 100, 0), 0).pos.x, 50);
}

TEST(Interpolated, OfOneDataSet) {
  EXPECT_EQ(interpolated(at(1000, 7, 0), at(1000, 7, 0), 1020).pos.x, 7);
}

TEST(Interpolated, PositionsAreAsUnsureAsTheLessSureOne) {
  PositionData before{
      .recordingTime = 1000, .pos = {.x = 0, .rho = static_cast<f32>(radians(350))}, .var = {}};
  PositionData after{.recordingTime = 1050,
                     .pos = {.x = 100, .y = -50, .rho = static_cast<f32>(radians(10))}};
  before.var.x = 400;
  after.var.x = 20;
  after.var.rho = 0.1F;
  const PositionData now = interpolated(before, after, 1025);
  EXPECT_EQ(now.recordingTime, TimeStamp(1025));
  EXPECT_EQ(now.pos.x, 50);
  EXPECT_EQ(now.pos.y, -25);
  EXPECT_NEAR(signed_angle(now.pos.rho.raw()), 0, 1e-6);
  EXPECT_EQ(now.var.x, 400);
  EXPECT_EQ(now.var.rho, 0.1F);
}

using namespace std::chrono_literals;

OdometryData odometry(u32 time, i32 x, i32 y = 0, double rho = 0) {
  return {.recordingTime = time, .pos = {.x = x, .y = y, .rho = static_cast<f32>(rho)}};
}

TEST(PositionTracker, IsTheOdometryAtFirst) {
  PositionTracker tracker({}, 0ms);
  const PositionData data = tracker.follow(odometry(5, 100, 200, 1));
  EXPECT_EQ(data.recordingTime, TimeStamp(5));
  EXPECT_EQ(data.pos.x, 100);
  EXPECT_EQ(data.pos.y, 200);
  EXPECT_FLOAT_EQ(data.pos.rho, 1);
  EXPECT_EQ(data.var.x, 0);
}

TEST(PositionTracker, BeginsAtTheOriginAndGoesOnWhereItWas) {
  PositionTracker tracker({}, 0ms);
  tracker.begin({.x = 50, .y = 50}, 0ms, odometry(0, 7000, 300, kPi / 2));
  EXPECT_EQ(tracker.follow(odometry(1, 7000, 300, kPi / 2)).pos.x, 0);
  PositionData data = tracker.follow(odometry(2, 7000, 1300, kPi / 2));
  EXPECT_EQ(data.pos.x, 1000) << "a metre ahead";
  EXPECT_EQ(data.pos.y, 0);
  EXPECT_NEAR(data.pos.rho, 0, 1e-6);
  const auto deviation = data.var.x;
  // Off and on again: in between the odometry was reset.
  tracker.begin({.x = 50, .y = 50}, 0ms, odometry(3, 0));
  data = tracker.follow(odometry(4, 0));
  EXPECT_EQ(data.pos.x, 1000);
  EXPECT_EQ(data.var.x, deviation);
  EXPECT_EQ(tracker.follow(odometry(5, 500)).pos.x, 1500);
}

TEST(PositionTracker, IsAsUncertainAsExpectedUntilItIsUpdated) {
  PositionTracker tracker({}, 0ms);
  tracker.expect(PositionTracker::kUnknown);
  tracker.begin({}, 0ms, odometry(1, 0));
  EXPECT_EQ(tracker.follow(odometry(2, 0)).var.x, PositionTracker::kUnknown);
  tracker.update({.var = {.x = 3, .y = 4}}, odometry(2, 0));
  tracker.expect(PositionTracker::kUnknown);
  EXPECT_EQ(tracker.follow(odometry(3, 0)).var.x, 3) << "off and on again";
}

TEST(PositionTracker, GoesOnFromAnUpdateWhileItBlends) {
  PositionTracker tracker({}, 1000ms);
  tracker.begin({}, 1000ms, odometry(0, 0));
  (void)tracker.follow(odometry(0, 0));
  tracker.update({.pos = {.x = 100}}, odometry(0, 0));
  EXPECT_EQ(tracker.follow(odometry(500, 0)).pos.x, 50);
  tracker.begin({}, 1000ms, odometry(600, 0));
  EXPECT_EQ(tracker.follow(odometry(700, 0)).pos.x, 50);
}

TEST(PositionTracker, GoesOnFromWhatWasKnown) {
  PositionTracker tracker({}, 0ms);
  (void)tracker.follow(odometry(0, 0));
  (void)tracker.follow(odometry(100, 1000));
  // At time 0 it stood at (5000, 0) and looked east: a metre ahead is a metre east.
  tracker.update({.pos = {.x = 5000, .rho = static_cast<f32>(kPi / 2)}}, odometry(0, 0));
  const PositionData data = tracker.follow(odometry(200, 2000));
  EXPECT_EQ(data.pos.x, 5000);
  EXPECT_EQ(data.pos.y, 2000);
  EXPECT_NEAR(data.pos.rho, kPi / 2, 1e-6);
}

TEST(PositionTracker, BecomesUncertainByMoving) {
  PositionTracker tracker({.x = 50, .y = 100}, 0ms);
  (void)tracker.follow(odometry(0, 0));
  for (u32 i = 1; i <= 1000; ++i) (void)tracker.follow(odometry(i, static_cast<i32>(i)));
  PositionData data = tracker.follow(odometry(1001, 1000));
  EXPECT_EQ(data.var.x, 50);
  EXPECT_EQ(data.var.y, 10);
  EXPECT_NEAR(data.var.rho, 0.01, 1e-6);
  data = tracker.follow(odometry(1002, 1000, 1000, 1));
  EXPECT_EQ(data.var.x, 70);
  EXPECT_EQ(data.var.y, 110);
  EXPECT_NEAR(data.var.rho, 0.12, 1e-6);
  tracker.update({.var = {.x = 3, .y = 4, .z = 5, .rho = 0.5F}}, odometry(1002, 1000, 1000, 1));
  data = tracker.follow(odometry(1003, 1000, 1000, 1));
  EXPECT_EQ(data.var.x, 3);
  EXPECT_EQ(data.var.z, 5);
  EXPECT_FLOAT_EQ(data.var.rho, 0.5F);
}

TEST(PositionTracker, AnUpdateOfThePastHasDriftedSince) {
  PositionTracker tracker({}, 0ms);
  (void)tracker.follow(odometry(0, 0));
  (void)tracker.follow(odometry(100, 1000));
  tracker.update({}, odometry(0, 0));
  EXPECT_EQ(tracker.follow(odometry(200, 1000)).var.x, 50);
}

TEST(PositionTracker, BlendsBitByBit) {
  PositionTracker tracker({}, 1000ms);
  (void)tracker.follow(odometry(0xFFFFFF00, 0));  // the time wraps in between
  tracker.update({.pos = {.x = 100, .y = 50}}, odometry(0xFFFFFF00, 0));
  EXPECT_EQ(tracker.follow(odometry(0xFFFFFF00, 0)).pos.x, 0);
  EXPECT_EQ(tracker.follow(odometry(0xFFFFFF00 + 500, 1000)).pos.x, 1050);
  EXPECT_EQ(tracker.follow(odometry(0xFFFFFF00 + 500, 1000)).pos.y, 25);
  EXPECT_EQ(tracker.follow(odometry(0xFFFFFF00 + 1000, 1000)).pos.x, 1100);
}

TEST(PositionTracker, ASecondUpdateBlendsFromWhereItIs) {
  PositionTracker tracker({}, 1000ms);
  (void)tracker.follow(odometry(0, 0));
  tracker.update({.pos = {.x = 100}}, odometry(0, 0));
  EXPECT_EQ(tracker.follow(odometry(500, 0)).pos.x, 50);
  tracker.update({.pos = {.x = 0}}, odometry(500, 0));
  EXPECT_EQ(tracker.follow(odometry(500, 0)).pos.x, 50);
  EXPECT_EQ(tracker.follow(odometry(1000, 0)).pos.x, 25);
  EXPECT_EQ(tracker.follow(odometry(1500, 0)).pos.x, 0);
}

}  // namespace reckoning_test

}  // namespace rack::navigation
