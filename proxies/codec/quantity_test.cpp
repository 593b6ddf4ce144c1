#include "rack/codec/quantity.h"

#include <cmath>
#include <limits>
#include <type_traits>

#include <gtest/gtest.h>

namespace rack {

namespace quantity_test {

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

}  // namespace quantity_test

namespace quantity_test {

using std::chrono::milliseconds;

TEST(TimeStamp, DifferencesAndSums) {
  const TimeStamp t = 1000;
  EXPECT_EQ(TimeStamp(1500) - t, milliseconds(500));
  EXPECT_EQ(t - TimeStamp(1500), milliseconds(-500));
  EXPECT_EQ(t + milliseconds(20), TimeStamp(1020));
  EXPECT_EQ(t - milliseconds(20), TimeStamp(980));
}

TEST(TimeStamp, AcrossTheWrap) {
  const TimeStamp before = 0xFFFFFFF0;
  const TimeStamp after = before + milliseconds(0x20);
  EXPECT_EQ(after.raw(), 0x10U);
  EXPECT_LT(before, after);
  EXPECT_GT(after, before);
  EXPECT_LE(before, before);
  EXPECT_EQ(after - before, milliseconds(0x20));
  EXPECT_EQ(before - after, milliseconds(-0x20));
  EXPECT_EQ(after - milliseconds(0x20), before);
}

TEST(TimeStamp, UpToHalfTheRing) {
  const TimeStamp t = 0xC0000000;
  EXPECT_LT(t, t + milliseconds(0x7FFFFFFF));
  EXPECT_GT(t, t - milliseconds(0x7FFFFFFF));
}

TEST(TimeStamp, OfAClockSince1970) {
  // 2026-01-01 00:00 UTC.
  const TimeStamp t = TimeStamp::of(milliseconds(1767225600000));
  EXPECT_EQ(t.raw(), static_cast<std::uint32_t>(1767225600000 % (std::int64_t{1} << 32)));
}

}  // namespace quantity_test

}  // namespace rack
