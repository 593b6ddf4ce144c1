#include "components/navigation/reference.h"

#include <gtest/gtest.h>

namespace rack::navigation {
namespace {

using namespace std::chrono_literals;

OdometryData odometry(u32 time, i32 x, i32 y = 0, double rho = 0) {
  return {.recordingTime = time, .pos = {.x = x, .y = y, .rho = static_cast<f32>(rho)}};
}

TEST(Reference, IsTheOdometryAtFirst) {
  Reference reference({}, 0ms);
  const PositionData data = reference.follow(odometry(5, 100, 200, 1));
  EXPECT_EQ(data.recordingTime, TimeStamp(5));
  EXPECT_EQ(data.pos.x, 100);
  EXPECT_EQ(data.pos.y, 200);
  EXPECT_FLOAT_EQ(data.pos.rho, 1);
  EXPECT_EQ(data.var.x, 0);
}

TEST(Reference, BeginsAtTheOriginAndGoesOnWhereItWas) {
  Reference reference({}, 0ms);
  reference.begin({.x = 50, .y = 50}, 0ms, odometry(0, 7000, 300, kPi / 2));
  EXPECT_EQ(reference.follow(odometry(1, 7000, 300, kPi / 2)).pos.x, 0);
  PositionData data = reference.follow(odometry(2, 7000, 1300, kPi / 2));
  EXPECT_EQ(data.pos.x, 1000) << "a metre ahead";
  EXPECT_EQ(data.pos.y, 0);
  EXPECT_NEAR(data.pos.rho, 0, 1e-6);
  const auto deviation = data.var.x;
  // Off and on again: meanwhile the odometry has begun anew.
  reference.begin({.x = 50, .y = 50}, 0ms, odometry(3, 0));
  data = reference.follow(odometry(4, 0));
  EXPECT_EQ(data.pos.x, 1000);
  EXPECT_EQ(data.var.x, deviation);
  EXPECT_EQ(reference.follow(odometry(5, 500)).pos.x, 1500);
}

TEST(Reference, GoesOnFromAnUpdateWhileItBlends) {
  Reference reference({}, 1000ms);
  reference.begin({}, 1000ms, odometry(0, 0));
  (void)reference.follow(odometry(0, 0));
  reference.update({.pos = {.x = 100}}, odometry(0, 0));
  EXPECT_EQ(reference.follow(odometry(500, 0)).pos.x, 50);
  reference.begin({}, 1000ms, odometry(600, 0));
  EXPECT_EQ(reference.follow(odometry(700, 0)).pos.x, 50);
}

TEST(Reference, GoesOnFromWhatWasKnown) {
  Reference reference({}, 0ms);
  (void)reference.follow(odometry(0, 0));
  (void)reference.follow(odometry(100, 1000));
  // At time 0 it stood at (5000, 0) and looked east: a metre ahead is a metre east.
  reference.update({.pos = {.x = 5000, .rho = static_cast<f32>(kPi / 2)}}, odometry(0, 0));
  const PositionData data = reference.follow(odometry(200, 2000));
  EXPECT_EQ(data.pos.x, 5000);
  EXPECT_EQ(data.pos.y, 2000);
  EXPECT_NEAR(data.pos.rho, kPi / 2, 1e-6);
}

TEST(Reference, BecomesUncertainByMoving) {
  Reference reference({.x = 50, .y = 100}, 0ms);
  (void)reference.follow(odometry(0, 0));
  for (u32 i = 1; i <= 1000; ++i) (void)reference.follow(odometry(i, static_cast<i32>(i)));
  PositionData data = reference.follow(odometry(1001, 1000));
  EXPECT_EQ(data.var.x, 50);
  EXPECT_EQ(data.var.y, 10);
  EXPECT_NEAR(data.var.rho, 0.01, 1e-6);
  data = reference.follow(odometry(1002, 1000, 1000, 1));
  EXPECT_EQ(data.var.x, 70);
  EXPECT_EQ(data.var.y, 110);
  EXPECT_NEAR(data.var.rho, 0.12, 1e-6);
  reference.update({.var = {.x = 3, .y = 4, .z = 5, .rho = 0.5F}}, odometry(1002, 1000, 1000, 1));
  data = reference.follow(odometry(1003, 1000, 1000, 1));
  EXPECT_EQ(data.var.x, 3);
  EXPECT_EQ(data.var.z, 5);
  EXPECT_FLOAT_EQ(data.var.rho, 0.5F);
}

TEST(Reference, AnUpdateOfThePastHasDriftedSince) {
  Reference reference({}, 0ms);
  (void)reference.follow(odometry(0, 0));
  (void)reference.follow(odometry(100, 1000));
  reference.update({}, odometry(0, 0));
  EXPECT_EQ(reference.follow(odometry(200, 1000)).var.x, 50);
}

TEST(Reference, BlendsBitByBit) {
  Reference reference({}, 1000ms);
  (void)reference.follow(odometry(0xFFFFFF00, 0));  // the time wraps meanwhile
  reference.update({.pos = {.x = 100, .y = 50}}, odometry(0xFFFFFF00, 0));
  EXPECT_EQ(reference.follow(odometry(0xFFFFFF00, 0)).pos.x, 0);
  EXPECT_EQ(reference.follow(odometry(0xFFFFFF00 + 500, 1000)).pos.x, 1050);
  EXPECT_EQ(reference.follow(odometry(0xFFFFFF00 + 500, 1000)).pos.y, 25);
  EXPECT_EQ(reference.follow(odometry(0xFFFFFF00 + 1000, 1000)).pos.x, 1100);
}

TEST(Reference, ASecondUpdateBlendsFromWhereItIs) {
  Reference reference({}, 1000ms);
  (void)reference.follow(odometry(0, 0));
  reference.update({.pos = {.x = 100}}, odometry(0, 0));
  EXPECT_EQ(reference.follow(odometry(500, 0)).pos.x, 50);
  reference.update({.pos = {.x = 0}}, odometry(500, 0));
  EXPECT_EQ(reference.follow(odometry(500, 0)).pos.x, 50);
  EXPECT_EQ(reference.follow(odometry(1000, 0)).pos.x, 25);
  EXPECT_EQ(reference.follow(odometry(1500, 0)).pos.x, 0);
}

}  // namespace
}  // namespace rack::navigation
