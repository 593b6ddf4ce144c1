#include "router/link/token_bucket.h"

#include <gtest/gtest.h>

namespace tims::link {
namespace {

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
