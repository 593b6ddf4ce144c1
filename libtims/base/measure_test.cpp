#include "base/measure.h"

#include <gtest/gtest.h>

namespace tims::base {
namespace measure_test {

using namespace std::chrono_literals;

TEST(Measure, WholeNumbersWithTheirUnit) {
  EXPECT_EQ(read_measure("250ms", kDurationUnits).count, 250'000'000);
  EXPECT_EQ(read_measure("2min", kDurationUnits).count, 120'000'000'000);
  EXPECT_EQ(read_measure("4KiB", kSizeUnitsRead).count, 4096);
  EXPECT_EQ(read_measure("262144", kSizeUnitsRead).count, 262144);
  EXPECT_EQ(read_measure("-1B", kSizeUnitsRead).count, -1);
}

TEST(Measure, ReportsWhatIsWrong) {
  const auto why = [](std::string_view text) { return read_measure(text, kDurationUnits).error; };
  EXPECT_EQ(why("5s"), MeasureError::kNone);
  EXPECT_EQ(why("much"), MeasureError::kNoNumber);
  EXPECT_EQ(why(""), MeasureError::kNoNumber);
  EXPECT_EQ(why("5"), MeasureError::kNoUnit);
  EXPECT_EQ(why("5sec"), MeasureError::kUnknownUnit);
  EXPECT_EQ(read_measure("1.5s", kDurationUnits).unit, ".5s");
  EXPECT_EQ(why("9223372037s"), MeasureError::kTooLarge);
  EXPECT_EQ(why("9223372036854775808ns"), MeasureError::kTooLarge);
}

TEST(Measure, DurationsOfACommandLine) {
  EXPECT_EQ(parse_duration("250ms"), 250ms);
  EXPECT_EQ(parse_duration("2s"), 2s);
  EXPECT_EQ(parse_duration("1.5"), 1500ms) << "a bare number is seconds";
  EXPECT_EQ(parse_duration("10us"), 10us);
  EXPECT_EQ(parse_duration("2min"), 2min);
  EXPECT_EQ(parse_duration("2m"), 2min);
  EXPECT_EQ(parse_duration("0"), 0s);
  for (const char* bad :
       {"", "s", "m", "-1s", "2 s", "2x", "1e400", "nan", "99999999999h", "1.2.3"})
    EXPECT_FALSE(parse_duration(bad)) << bad;
}

TEST(Measure, SizesOfACommandLine) {
  EXPECT_EQ(parse_size("64"), 64U);
  EXPECT_EQ(parse_size("4KiB"), 4096U);
  EXPECT_EQ(parse_size("1.5kB"), 1500U);
  for (const char* bad : {"", "4 KiB", "-1", "5GiB", "x"}) EXPECT_FALSE(parse_size(bad)) << bad;
}

TEST(Measure, TheLargestUnitThatSaysItExactly) {
  EXPECT_EQ(exact_text(4096 << 10, kSizeUnits), "4MiB");
  EXPECT_EQ(exact_text(4'000'000, kSizeUnits), "4000000B");
  EXPECT_EQ(exact_text(4'000'000, kRateUnits), "4MB");
  EXPECT_EQ(exact_text(0, kDurationUnits), "0ns");
  EXPECT_EQ(exact_text(1'500'000'000, kDurationUnits), "1500ms");
}

TEST(Measure, RoundedForPeople) {
  EXPECT_EQ(human_count(812), "812");
  EXPECT_EQ(human_count(99'999), "99999");
  EXPECT_EQ(human_count(123'400), "123.4k");
  EXPECT_EQ(human_bytes(812), "812 B");
  EXPECT_EQ(human_bytes(12.4 * 1024), "12.4 KiB");
  EXPECT_EQ(human_duration(0), "0s");
  EXPECT_EQ(human_duration(14.2e-6), "14.2us");
  EXPECT_EQ(human_duration(-3.1e-3), "-3.10ms");
  EXPECT_EQ(human_duration(2.5), "2.50s");
  EXPECT_EQ(human_duration(130), "2m 10s");
  EXPECT_EQ(human_duration(3600 * 5 + 120), "5h 2m");
  EXPECT_EQ(human_duration(86400 * 3 + 3600 * 4), "3d 4h");
  EXPECT_EQ(human_rate(75), "75.0");
  EXPECT_EQ(human_rate(0.2), "0.20");
  EXPECT_EQ(human_rate(124'000), "124.0k");
}

// --- the calendar

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

}  // namespace measure_test
}  // namespace tims::base
