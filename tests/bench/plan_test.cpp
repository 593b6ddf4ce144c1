#include "tests/bench/plan.h"

#include <gtest/gtest.h>

namespace tims::bench {
namespace plan_test {

TEST(Plan, IsUnchangedByACommandLine) {
  Plan plan;
  plan.role = "sink";
  plan.link = "tims";
  plan.host = "10.77.0.1";
  plan.payload = 1 << 20;
  plan.index = 7;
  plan.priority = 255;
  plan.seconds = std::chrono::milliseconds(1500);
  const auto parsed = parse_plan(to_arguments(plan));
  ASSERT_TRUE(parsed) << parsed.error().message();
  EXPECT_EQ(to_arguments(*parsed), to_arguments(plan));
  EXPECT_EQ(parsed->seconds, plan.seconds);
}

TEST(Plan, RefusesUnknownArguments) {
  const std::vector<std::string> unknown{"--rolle", "sink"};
  const std::vector<std::string> no_number{"--payload", "64k"};
  EXPECT_FALSE(parse_plan(unknown));
  EXPECT_FALSE(parse_plan(no_number));
}

TEST(Plan, WindowIsFourMebibytesWithinBounds) {
  EXPECT_EQ(window_of(64), 4096U);
  EXPECT_EQ(window_of(1024), 4096U);
  EXPECT_EQ(window_of(64 << 10), 64U);
  EXPECT_EQ(window_of(1 << 20), 4U);
  EXPECT_EQ(window_of(16 << 20), 4U);
}

}  // namespace plan_test
}  // namespace tims::bench
