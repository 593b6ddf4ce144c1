#include "base/rate_limiter.h"

#include <gtest/gtest.h>

namespace tims::base {
namespace rate_limiter_test {

using namespace std::chrono_literals;

TEST(RateLimiter, LetsItsRateThrough) {
  RateLimiter limiter;
  EXPECT_TRUE(limiter.ready(Time{1s}));
  limiter.set(1'000'000, 2000);
  Time now{1s};
  std::uint64_t bytes = 0;
  while (now < Time{3s}) {
    now = limiter.ready_at(now);
    EXPECT_TRUE(limiter.ready(now));
    limiter.take(1000);
    bytes += 1000;
  }
  EXPECT_NEAR(static_cast<double>(bytes), 2'000'000, 5000);
}

constexpr std::uint32_t kBurst = 50;

TEST(LineLimiter, LetsABurstPassAndThenASteadyRate) {
  LineLimiter limiter(10, kBurst);
  const Time start(1000s);
  for (std::uint32_t i = 0; i < kBurst; ++i) EXPECT_TRUE(limiter.take(start)) << i;
  EXPECT_FALSE(limiter.take(start));
  EXPECT_FALSE(limiter.take(start + 99ms));
  EXPECT_TRUE(limiter.take(start + 100ms));
  EXPECT_FALSE(limiter.take(start + 100ms));
  EXPECT_EQ(limiter.take_held_back(), 3U);
  EXPECT_EQ(limiter.take_held_back(), 0U);
}

TEST(LineLimiter, RecoversDuringSilence) {
  LineLimiter limiter(10, kBurst);
  Time now(1000s);
  while (limiter.take(now)) {
  }
  now += 1h;
  std::uint32_t passed = 0;
  while (limiter.take(now)) ++passed;
  EXPECT_EQ(passed, kBurst);
}

TEST(LineLimiter, BurstAndRateCanBeOthers) {
  LineLimiter limiter(1, 2);
  const Time now(1000s);
  EXPECT_TRUE(limiter.is_idle(now));
  EXPECT_TRUE(limiter.take(now));
  EXPECT_TRUE(limiter.take(now));
  EXPECT_FALSE(limiter.take(now));
  EXPECT_FALSE(limiter.is_idle(now + 1h)) << "one suppressed line is to be reported";
  (void)limiter.take_held_back();
  EXPECT_FALSE(limiter.is_idle(now + 1s));
  EXPECT_TRUE(limiter.is_idle(now + 2s));
}

}  // namespace rate_limiter_test
}  // namespace tims::base
