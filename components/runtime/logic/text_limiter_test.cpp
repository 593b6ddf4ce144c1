#include "components/runtime/logic/text_limiter.h"

#include <gtest/gtest.h>

namespace rack {
namespace {

using namespace std::chrono_literals;

TEST(TextLimiter, LetsABurstPassAndThenASteadyRate) {
  TextLimiter limiter;
  const tims::Time start(1000s);
  for (std::uint32_t i = 0; i < TextLimiter::kBurst; ++i) EXPECT_TRUE(limiter.take(start)) << i;
  EXPECT_FALSE(limiter.take(start));
  EXPECT_FALSE(limiter.take(start + 99ms));
  EXPECT_TRUE(limiter.take(start + 100ms));
  EXPECT_FALSE(limiter.take(start + 100ms));
  EXPECT_EQ(limiter.take_suppressed(), 3U);
  EXPECT_EQ(limiter.take_suppressed(), 0U);
}

TEST(TextLimiter, RecoversWhileNothingIsSaid) {
  TextLimiter limiter;
  tims::Time now(1000s);
  while (limiter.take(now)) {
  }
  now += 1h;
  std::uint32_t passed = 0;
  while (limiter.take(now)) ++passed;
  EXPECT_EQ(passed, TextLimiter::kBurst);
}

TEST(TextLimiter, BurstAndRateCanBeOthers) {
  TextLimiter limiter(2, 1s);
  const tims::Time now(1000s);
  EXPECT_TRUE(limiter.is_idle(now));
  EXPECT_TRUE(limiter.take(now));
  EXPECT_TRUE(limiter.take(now));
  EXPECT_FALSE(limiter.take(now));
  EXPECT_FALSE(limiter.is_idle(now + 1h)) << "one is to be told";
  (void)limiter.take_suppressed();
  EXPECT_FALSE(limiter.is_idle(now + 1s));
  EXPECT_TRUE(limiter.is_idle(now + 2s));
}

}  // namespace
}  // namespace rack
