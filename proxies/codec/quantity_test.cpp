#include "proxies/codec/quantity.h"

#include <cmath>
#include <limits>
#include <type_traits>

#include <gtest/gtest.h>

namespace rack {
namespace {

TEST(Quantity, IsTheNumberOfTheWire) {
  MillimetresPerSecond<i32> vx = 200;
  vx = vx + 50;
  const i32 raw = vx;
  EXPECT_EQ(raw, 250);
  EXPECT_TRUE(vx > 249);
  static_assert(sizeof(vx) == sizeof(i32));
  static_assert(std::is_trivially_copyable_v<decltype(vx)>);
}

TEST(Quantity, SpeaksSi) {
  EXPECT_DOUBLE_EQ(Millimetres<i32>(1500).si(), 1.5);
  EXPECT_DOUBLE_EQ((Quantity<f32, unit::PerMillimetre>(0.5F).si()), 500.0);
  EXPECT_DOUBLE_EQ(Percent<f32>(50).si(), 0.5);
  EXPECT_EQ(Millimetres<i32>::from_si(1.5).raw(), 1500);
  EXPECT_EQ(Milliseconds<u32>::from_si(0.1).raw(), 100U);
  EXPECT_EQ(Radians<f32>::from_si(0.5).raw(), 0.5F);
}

TEST(Quantity, RoundsToTheNearest) {
  EXPECT_EQ(Millimetres<i32>::from_si(0.0016).raw(), 2);
  EXPECT_EQ(Millimetres<i32>::from_si(-0.0016).raw(), -2);
  EXPECT_EQ(Millimetres<i32>::from_si(0.0014).raw(), 1);
}

TEST(Quantity, KeepsToTheRangeOfItsNumber) {
  EXPECT_EQ(Millimetres<i32>::from_si(1e12).raw(), std::numeric_limits<i32>::max());
  EXPECT_EQ(Millimetres<i32>::from_si(-1e12).raw(), std::numeric_limits<i32>::min());
  EXPECT_EQ(Milliseconds<u32>::from_si(-1).raw(), 0U);
  EXPECT_EQ(Millimetres<i64>::from_si(1e300).raw(), std::numeric_limits<i64>::max());
  EXPECT_EQ(Millimetres<i64>::from_si(-1e300).raw(), std::numeric_limits<i64>::min());
  EXPECT_EQ(Millimetres<i32>::from_si(std::nan("")).raw(), 0);
  EXPECT_TRUE(std::isnan(Radians<f32>::from_si(std::nan("")).raw()));
}

TEST(Quantity, KnowsHowItsUnitIsWritten) {
  EXPECT_EQ(Millimetres<i32>::Unit::kName, "mm");
  EXPECT_EQ(RadiansPerSecond<f32>::Unit::kName, "rad/s");
}

}  // namespace
}  // namespace rack
