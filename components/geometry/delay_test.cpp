#include "components/geometry/delay.h"

#include <gtest/gtest.h>

namespace rack::device {
namespace delay_test {

using namespace std::chrono_literals;

constexpr tims::Time kBegin{100s};

TEST(DelayTest, NothingIsTakenBeforeItIsDue) {
  Delay<int> delay;
  EXPECT_EQ(delay.newest(), nullptr);
  EXPECT_FALSE(delay.take(kBegin));
  delay.tell(1, kBegin + 50ms);
  delay.tell(2, kBegin + 60ms);
  EXPECT_EQ(delay.newest()->command, 2);
  EXPECT_FALSE(delay.take(kBegin + 50ms - 1ns));
  const auto first = delay.take(kBegin + 50ms);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->command, 1);
  EXPECT_EQ(first->at, kBegin + 50ms);
  EXPECT_FALSE(delay.take(kBegin + 50ms));
  EXPECT_EQ(delay.take(kBegin + 1s)->command, 2);
  EXPECT_EQ(delay.newest(), nullptr);
}

TEST(DelayTest, OneNeverOvertakesAnother) {
  Delay<int> delay;
  delay.tell(1, kBegin + 50ms);
  delay.tell(2, kBegin + 10ms);
  EXPECT_FALSE(delay.take(kBegin + 49ms));
  EXPECT_EQ(delay.take(kBegin + 50ms)->command, 1);
  EXPECT_EQ(delay.take(kBegin + 50ms)->command, 2);
}

TEST(DelayTest, WhatIsForgottenIsNotDone) {
  Delay<int> delay;
  delay.tell(1, kBegin);
  delay.forget();
  EXPECT_FALSE(delay.take(kBegin + 1s));
}

// The place of the last one only, wherever the ring begins.
TEST(DelayTest, WhenTooManyAreUnderWayTheNewestTakesTheLastOnesPlace) {
  constexpr int kMax = Delay<int>::kUnderWayMax;
  for (const int begun : {0, 1, kMax - 1}) {
    for (const int told : {kMax - 1, kMax, kMax + 1, 3 * kMax}) {
      Delay<int> delay;
      for (int i = 0; i < begun; ++i) {
        delay.tell(-1, kBegin);
        ASSERT_TRUE(delay.take(kBegin));
      }
      for (int i = 1; i <= told; ++i) delay.tell(i, kBegin);
      const int kept = std::min(told, kMax);
      for (int i = 1; i < kept; ++i) ASSERT_EQ(delay.take(kBegin)->command, i);
      EXPECT_EQ(delay.take(kBegin)->command, told);
      EXPECT_FALSE(delay.take(kBegin));
    }
  }
}

}  // namespace delay_test
}  // namespace rack::device
