#include "components/devices/drivers/host_clock.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/drivers/driver.h"

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
}

}  // namespace host_clock_test
}  // namespace rack::device
