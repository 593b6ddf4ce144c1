#include "router/link/estimators.h"

#include <gtest/gtest.h>

namespace tims::link {
namespace estimators_test {

TEST(ClockOffset, TheShortestRoundTripCounts) {
  ClockOffset clock;
  EXPECT_FALSE(clock.best().has_value());
  clock.add(1000, 6000, 6100, 9100);  // delayed on the return path
  clock.add(20'000, 25'010, 25'020, 20'030);
  ASSERT_TRUE(clock.best().has_value());
  EXPECT_EQ(clock.best()->offset, 5000);
  EXPECT_EQ(clock.best()->round_trip, 20);
  clock.add(INT64_MIN, INT64_MAX, INT64_MIN, INT64_MAX);  // arbitrary values
}

using namespace std::chrono_literals;

}  // namespace estimators_test
}  // namespace tims::link
