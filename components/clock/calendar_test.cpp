#include "components/clock/calendar.h"

#include <gtest/gtest.h>

namespace rack::clock {
namespace calendar_test {

TEST(Calendar, TheBeginning) {
  const ClockData clock = clock_of(std::chrono::seconds(0));
  EXPECT_EQ(clock.day, 1);
  EXPECT_EQ(clock.month, 1);
  EXPECT_EQ(clock.year, 1970);
  EXPECT_EQ(clock.dayOfWeek, 4) << "a Thursday";
}

TEST(Calendar, ALeapDayAndASunday) {
  const ClockData clock = clock_of(std::chrono::seconds(1709251199));  // 2024-02-29 23:59:59
  EXPECT_EQ(clock.hour, 23);
  EXPECT_EQ(clock.minute, 59);
  EXPECT_EQ(clock.second, 59);
  EXPECT_EQ(clock.day, 29);
  EXPECT_EQ(clock.month, 2);
  EXPECT_EQ(clock.year, 2024);
  EXPECT_EQ(clock.utcTime, 1709251199);
  EXPECT_EQ(clock.dayOfWeek, 4);
  EXPECT_EQ(clock_of(std::chrono::seconds(1709251199 + 3 * 86400)).dayOfWeek, 7);
}

TEST(Calendar, BeforeTheBeginning) {
  const ClockData clock = clock_of(std::chrono::seconds(-1));
  EXPECT_EQ(clock.second, 59);
  EXPECT_EQ(clock.year, 1969);
}

TEST(TimeBy, AnotherClock) {
  using namespace std::chrono_literals;
  ClockData other{.recordingTime = 5000, .utcTime = 1709251199, .syncMode = 1};
  EXPECT_EQ(time_by(other, 5000), 1709251199000ms);
  EXPECT_EQ(time_by(other, 7345), 1709251201345ms) << "more than a second old";
  EXPECT_EQ(time_by(other, 4990), 1709251199000ms);
  other.recordingTime = 0xFFFFFFF0;
  EXPECT_EQ(time_by(other, 16), 1709251199032ms) << "the time stamps wrapped";
  other.syncMode = 0;
  EXPECT_EQ(time_by(other, 16), std::nullopt) << "it does not know itself";
}

}  // namespace calendar_test
}  // namespace rack::clock
