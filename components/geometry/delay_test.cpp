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
  delay.push(1, kBegin + 50ms);
  delay.push(2, kBegin + 60ms);
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
  delay.push(1, kBegin + 50ms);
  delay.push(2, kBegin + 10ms);
  EXPECT_FALSE(delay.take(kBegin + 49ms));
  EXPECT_EQ(delay.take(kBegin + 50ms)->command, 1);
  EXPECT_EQ(delay.take(kBegin + 50ms)->command, 2);
}

TEST(DelayTest, WhatIsForgottenIsNotDone) {
  Delay<int> delay;
  delay.push(1, kBegin);
  delay.forget();
  EXPECT_FALSE(delay.take(kBegin + 1s));
}

// The place of the last one only, wherever the ring begins.
TEST(DelayTest, WhenFullTheNewestReplacesTheLastOne) {
  constexpr int kMax = Delay<int>::kInFlightMax;
  for (const int begun : {0, 1, kMax - 1}) {
    for (const int pushed : {kMax - 1, kMax, kMax + 1, 3 * kMax}) {
      Delay<int> delay;
      for (int i = 0; i < begun; ++i) {
        delay.push(-1, kBegin);
        ASSERT_TRUE(delay.take(kBegin));
      }
      for (int i = 1; i <= pushed; ++i) delay.push(i, kBegin);
      const int kept = std::min(pushed, kMax);
      for (int i = 1; i < kept; ++i) ASSERT_EQ(delay.take(kBegin)->command, i);
      EXPECT_EQ(delay.take(kBegin)->command, pushed);
      EXPECT_FALSE(delay.take(kBegin));
    }
  }
}

TEST(LaggingCommandTest, TheTimeIsDividedWhereACommandTakesEffect) {
  LaggingCommand<double> speed;
  double distance = 0;
  const auto step = [&](tims::Time now) {
    speed.step(now, [&](double seconds) { distance += speed.in_effect() * seconds; });
  };
  speed.set_lag(300ms);
  step(kBegin);
  speed.set(10);
  EXPECT_EQ(speed.newest(), 10);
  EXPECT_EQ(speed.in_effect(), 0);
  step(kBegin + 200ms);
  EXPECT_EQ(distance, 0);
  step(kBegin + 800ms);
  EXPECT_NEAR(distance, 5, 1e-9);
  step(kBegin + 100ms);  // from the line, late
  EXPECT_NEAR(distance, 5, 1e-9);
  step(kBegin + 900ms);
  EXPECT_NEAR(distance, 6, 1e-9);
}

TEST(LaggingCommandTest, WithoutALagItTakesEffectImmediately) {
  LaggingCommand<int> command;
  command.set(7);
  EXPECT_EQ(command.in_effect(), 7);
  EXPECT_EQ(command.newest(), 7);
}

}  // namespace delay_test
}  // namespace rack::device
