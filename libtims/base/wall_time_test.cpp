#include "base/wall_time.h"

#include <gtest/gtest.h>

namespace tims::base {
namespace {

using namespace std::chrono_literals;

const WallTime kTime{1763780400123ms};  // 2025-11-22, three o'clock

TEST(WallTime, Rfc3339) {
  EXPECT_EQ(rfc3339(kTime), "2025-11-22T03:00:00.123000Z");
  EXPECT_EQ(rfc3339(kTime, 3), "2025-11-22T03:00:00.123Z");
  EXPECT_EQ(rfc3339(kTime, 0), "2025-11-22T03:00:00Z");
  EXPECT_EQ(rfc3339(WallTime(-1ns), 9), "1969-12-31T23:59:59.999999999Z");
}

TEST(WallTime, ReadsItBack) {
  for (const int digits : {3, 6, 9}) EXPECT_EQ(parse_rfc3339(rfc3339(kTime, digits)), kTime);
  EXPECT_EQ(parse_rfc3339("2025-11-22T03:00:00Z"), kTime - 123ms);
  EXPECT_EQ(parse_rfc3339("2025-11-22T03:00:00.1Z"), kTime - 23ms);
  EXPECT_EQ(parse_rfc3339("2024-02-29T00:00:00Z").has_value(), true);
}

TEST(WallTime, AnythingElseIsNone) {
  for (const char* bad :
       {"", "2025-11-22", "2025-11-22T03:00:00", "2025-11-22 03:00:00Z", "2025-11-22T25:00:00Z",
        "2025-02-30T03:00:00Z", "2025-11-22T03:60:00Z", "2025-11-22T03:00:60Z",
        "2025-11-22T03:00:00.Z", "2025-11-22T03:00:00.1x3Z", "2025-11-22T03:00:00+01Z",
        "-025-11-22T03:00:00Z", "2025-11-22T03:00:00.-1Z"})
    EXPECT_FALSE(parse_rfc3339(bad)) << bad;
}

TEST(WallTime, NoYearThatNanosecondsDoNotReach) {
  for (const char* last : {"1678-01-01T00:00:00Z", "2261-12-31T23:59:59.999999999Z"}) {
    const auto time = parse_rfc3339(last);
    ASSERT_TRUE(time) << last;
    EXPECT_EQ(rfc3339(*time, 9).substr(0, 19), std::string(last).substr(0, 19));
  }
  for (const char* beyond :
       {"1677-12-31T23:59:59Z", "2262-01-01T00:00:00Z", "3026-11-22T03:00:00Z"})
    EXPECT_FALSE(parse_rfc3339(beyond)) << beyond;
}

TEST(WallTime, DayAndTimeOfDay) {
  EXPECT_EQ(date(kTime), "2025-11-22");
  EXPECT_EQ(time_of_day(kTime), "03:00:00.123");
}

}  // namespace
}  // namespace tims::base
