#include "components/navigation/dead_reckoning.h"

#include <limits>

#include <gtest/gtest.h>

namespace rack::navigation {
namespace {

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

}  // namespace
}  // namespace rack::navigation
