#include "tools/robot/program.h"

#include <gtest/gtest.h>

namespace timsctl::robot {
namespace program_test {

using namespace std::chrono_literals;

constexpr int kKilled = 128 + 9;

TEST(RestartPolicy, OnFailureOnly) {
  RestartPolicy policy(Restart::kOnFailure);
  EXPECT_EQ(policy.ended(0, 1s), std::nullopt);
  EXPECT_EQ(policy.ended(1, 1s), kFirstPause);
  EXPECT_EQ(policy.ended(kKilled, 1s), 2 * kFirstPause);
}

TEST(RestartPolicy, AlwaysAndNever) {
  EXPECT_EQ(RestartPolicy(Restart::kAlways).ended(0, 1s), kFirstPause);
  EXPECT_EQ(RestartPolicy(Restart::kNever).ended(kKilled, 1s), std::nullopt);
}

TEST(RestartPolicy, AWrongCommandLineStaysWrong) {
  EXPECT_EQ(RestartPolicy(Restart::kAlways).ended(kUsage, 0s), std::nullopt);
}

TEST(RestartPolicy, LessAndLessOftenUntilItHasRunForAWhile) {
  RestartPolicy policy(Restart::kOnFailure);
  tims::Duration pause{};
  for (int i = 0; i < 20; ++i) {
    const auto next = policy.ended(1, kStableAfter - 1ns);
    ASSERT_TRUE(next);
    EXPECT_GE(*next, pause);
    pause = *next;
  }
  EXPECT_EQ(pause, kLongestPause);
  EXPECT_EQ(policy.ended(1, kStableAfter), kFirstPause);
}

}  // namespace program_test
}  // namespace timsctl::robot
