#include "rack/devices/device_clock.h"

#include <random>

#include <gtest/gtest.h>

namespace rack::device {
namespace device_clock_test {

using namespace std::chrono_literals;

TEST(DeviceClockTest, ABytesTimeOnTheLine) {
  EXPECT_EQ(line_time(1, 10), 1s);
  EXPECT_EQ(line_time(372, 500000), 7440us);
  EXPECT_EQ(line_time(0, 9600), 0s);
}

// A counter of milliseconds, a network that delays by 1 to 30 ms, a crystal off by 100 ppm.
TEST(DeviceClockTest, FindsTheTimeWithinTheLeastDelay) {
  std::mt19937 random(7);
  std::exponential_distribution<double> delay(1.0 / 5);
  DeviceClock clock(1ms, 1ULL << 32);
  const Time start = Time(1000s);
  for (int i = 0; i < 20'000; ++i) {
    const Duration real = i * 20ms;
    const auto counter =
        static_cast<std::uint64_t>(12345 + static_cast<double>(real.count()) * 1.0001 / 1e6);
    const Duration late = 1ms + std::chrono::nanoseconds(static_cast<long>(delay(random) * 1e6));
    const Time measured = clock.to_host(counter, start + real + late);
    EXPECT_LE(measured, start + real + late);
    if (i < 500) continue;
    EXPECT_NEAR(static_cast<double>((measured - (start + real)).count()) / 1e6, 1, 2.2) << i;
  }
}

TEST(DeviceClockTest, FollowsACounterThatWrapsOrRestarts) {
  DeviceClock clock(1ms, 1 << 24);
  const std::uint64_t near_end = (1 << 24) - 10;
  EXPECT_EQ(clock.to_host(near_end, Time(100s)), Time(100s));
  EXPECT_EQ(clock.to_host(10, Time(100s + 25ms)), Time(100s + 20ms));
  EXPECT_EQ(clock.to_host(5, Time(200s)), Time(200s));  // switched off and on
}

TEST(DeviceClockTest, NoCounterLeadsOutOfTheLastSeconds) {
  std::mt19937_64 random(3);
  DeviceClock clock(1ns, 0);
  Time now(1000s);
  for (int i = 0; i < 10'000; ++i, now += 20ms) {
    const Time measured = clock.to_host(i % 3 == 0 ? random() % 1000 : random(), now);
    ASSERT_LE(measured, now);
    ASSERT_GE(measured, now - 5s);
  }
}

// Every other one is late, by up to half a turn, and a few are lost.
TEST(TurnClockTest, WhatIsLateIsPutBackToItsTurn) {
  std::mt19937_64 random(5);
  constexpr Duration kTurn = 13'333us;
  for (const double slow : {-0.004, 0.0, 0.004}) {
    TurnClock clock(kTurn);
    Time now(1000s);
    Duration worst{};
    for (int i = 0; i < 5000; ++i) {
      now += std::chrono::duration_cast<Duration>(kTurn * (1 + slow));
      if (random() % 50 == 0) continue;
      const Duration late = random() % 2 == 0 ? Duration(0) : Duration(random() % 6'500'000);
      const Time measured = clock.to_host(now + late);
      EXPECT_LE(measured, now + late);
      if (i < 50) continue;
      EXPECT_GE(measured, now);
      worst = std::max(worst, measured - now);
    }
    EXPECT_LT(worst, 1500us) << slow;
  }
}

TEST(TurnClockTest, RestartsAfterAPauseAndWhenAClockWasSetBack) {
  TurnClock clock(10ms);
  EXPECT_EQ(clock.to_host(Time(100s)), Time(100s));
  EXPECT_EQ(clock.to_host(Time(100s) + 14ms), Time(100s) + 10050us) << "late, or a little slow";
  EXPECT_EQ(clock.to_host(Time(100s) + 16ms), Time(100s) + 16ms) << "one of them was late";
  EXPECT_EQ(clock.to_host(Time(103s)), Time(103s));
  EXPECT_EQ(clock.to_host(Time(50s)), Time(50s));
}

TEST(StampedAtTest, AClockThatWasSetMeanwhileMovesNothing) {
  const Time now{1000s};
  const Duration wall = 24h * 365 * 56;
  EXPECT_EQ(stamped_at(wall - 3ms, wall, now), now - 3ms);
  for (const Duration step : {Duration(1h), Duration(2s), Duration(24h * 365)}) {
    EXPECT_EQ(stamped_at(wall - 3ms, wall + step, now), now) << "set forward";
    EXPECT_EQ(stamped_at(wall - 3ms, wall - step, now), now) << "set back";
  }
}

}  // namespace device_clock_test
}  // namespace rack::device
