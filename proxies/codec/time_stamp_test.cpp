#include "proxies/codec/time_stamp.h"

#include <gtest/gtest.h>

namespace rack {
namespace {

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

}  // namespace
}  // namespace rack
