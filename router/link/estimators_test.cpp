#include "router/link/estimators.h"

#include <gtest/gtest.h>

namespace tims::link {
namespace {

TEST(ClockOffset, TheShortestRoundTripCounts) {
  ClockOffset clock;
  EXPECT_FALSE(clock.best().has_value());
  clock.add(1000, 6000, 6100, 9100);  // on the way back something waited
  clock.add(20'000, 25'010, 25'020, 20'030);
  ASSERT_TRUE(clock.best().has_value());
  EXPECT_EQ(clock.best()->offset, 5000);
  EXPECT_EQ(clock.best()->round_trip, 20);
  clock.add(INT64_MIN, INT64_MAX, INT64_MIN, INT64_MAX);  // whatever they say
}

using namespace std::chrono_literals;

TEST(TokenBucket, LetsItsRateThrough) {
  TokenBucket bucket;
  EXPECT_TRUE(bucket.ready(Time{1s}));
  bucket.set(1'000'000, 2000);
  Time now{1s};
  std::uint64_t bytes = 0;
  while (now < Time{3s}) {
    now = bucket.ready_at(now);
    EXPECT_TRUE(bucket.ready(now));
    bucket.take(1000);
    bytes += 1000;
  }
  EXPECT_NEAR(static_cast<double>(bytes), 2'000'000, 5000);
}

}  // namespace
}  // namespace tims::link
