#include "components/devices/drivers/host_clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "rack/devices/driver.h"

namespace rack::device {
namespace host_clock_test {

using namespace std::chrono_literals;

TEST(HostClockTest, SmallDifferencesWithoutAJumpLargeOnesForward) {
  EXPECT_EQ(clock_change(0ms), ClockChange::kSlowly);
  EXPECT_EQ(clock_change(-99ms), ClockChange::kSlowly);
  EXPECT_EQ(clock_change(99ms), ClockChange::kSlowly);
  EXPECT_EQ(clock_change(101ms), ClockChange::kAtOnce);
  EXPECT_EQ(clock_change(-24h * 365 * 50), ClockChange::kAtOnce);  // a host that starts in 1970
}

TEST(HostClockTest, NotBackByMoreThanADay) {
  EXPECT_EQ(clock_change(23h), ClockChange::kAtOnce);
  EXPECT_EQ(clock_change(25h), ClockChange::kRefused);
  EXPECT_EQ(clock_change(24h * 7 * 1024), ClockChange::kRefused);
}

// nmea-cold-date.nmea: a receiver starts with a date of its own, then knows the right one.
TEST(ClockDecisionTest, OneWrongDateEndsNothing) {
  ClockDecision decision;
  const tims::Time begin(1000s);
  EXPECT_EQ(decision.decide(24h * 17000, begin), ClockChange::kRefused);
  EXPECT_TRUE(decision.is_first_refusal());
  EXPECT_EQ(decision.decide(24h * 17000, begin + 1s), ClockChange::kRefused);
  EXPECT_FALSE(decision.is_first_refusal());
  EXPECT_EQ(decision.decide(50ms, begin + 2s), ClockChange::kSlowly);
  EXPECT_EQ(decision.decide(-2h, begin + 3s), ClockChange::kAtOnce);
  EXPECT_EQ(decision.decide(24h * 17000, begin + 4s), ClockChange::kRefused);
  EXPECT_TRUE(decision.is_first_refusal());
}

// A date that is too late would set the clock ahead, and the right one could not set it back.
TEST(ClockDecisionTest, ALargeStepForwardMustBeConfirmed) {
  ClockDecision decision;
  const tims::Time begin(1000s);
  EXPECT_EQ(decision.decide(-24h, begin), ClockChange::kAtOnce);
  EXPECT_EQ(decision.decide(-24h * 7000, begin), ClockChange::kUnconfirmed);
  EXPECT_EQ(decision.decide(20ms, begin + 1s), ClockChange::kSlowly);
  EXPECT_EQ(decision.decide(-24h * 7000, begin + 11s), ClockChange::kUnconfirmed) << "again";
  EXPECT_EQ(decision.decide(-24h * 9000, begin + 12s), ClockChange::kUnconfirmed) << "another";
  EXPECT_EQ(decision.decide(-24h * 9000 - 1s, begin + 21s), ClockChange::kUnconfirmed);
  EXPECT_EQ(decision.decide(-24h * 9000, begin + 22s), ClockChange::kAtOnce);
}

// A measurement 20 ms ago has a time stamp 20 ms before the current wall clock, even if that clock
// was set in between.
TEST(TimeStampTest, FollowsTheClockOnTheWall) {
  const tims::Time measured(500s);
  for (const auto wall : {std::chrono::milliseconds(5h), std::chrono::milliseconds(2h)})
    EXPECT_EQ(time_stamp_of(measured, measured + 20ms, TimeStamp::of(wall)),
              TimeStamp::of(wall - 20ms));
}

// Not enabled: the clock of the test host must not change.
TEST(HostClockTest, IsUnchangedUnlessConfigured) {
  HostClock clock;
  clock.start(false, 1s);
  const auto updated = clock.update(0s, tims::Time(1s), tims::Time(1s));
  ASSERT_TRUE(updated);
  EXPECT_FALSE(*updated);
  clock.start(true, 1s);
  const auto refused = clock.update(0s, tims::Time(1s), tims::Time(1s));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().detail(), testing::HasSubstr("days behind"));
  const auto again = clock.update(0s, tims::Time(2s), tims::Time(2s));
  ASSERT_TRUE(again) << "reported once";
  EXPECT_FALSE(*again);
}

}  // namespace host_clock_test
}  // namespace rack::device
