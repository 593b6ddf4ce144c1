#include "components/devices/video_reader/pacing.h"

#include <gtest/gtest.h>

namespace rack::device {
namespace pacing_test {

using namespace std::chrono_literals;
constexpr Time kStart{1000s};

TEST(PacingTest, FramesAreDueAtTheirTimes) {
  Pacing pacing(1);
  EXPECT_EQ(pacing.due(kStart, 2s), kStart);  // a file may begin at any time
  EXPECT_EQ(pacing.due(kStart + 5ms, 2s + 40ms), kStart + 40ms);
  EXPECT_EQ(pacing.due(kStart + 45ms, 2s + 80ms), kStart + 80ms);
}

TEST(PacingTest, SpeedIsAFactor) {
  Pacing fast(2);
  EXPECT_EQ(fast.due(kStart, 0s), kStart);
  EXPECT_EQ(fast.due(kStart, 1s), kStart + 500ms);
  Pacing slow(0.5);
  EXPECT_EQ(slow.due(kStart, 0s), kStart);
  EXPECT_EQ(slow.due(kStart, 1s), kStart + 2s);
  Pacing none(0);
  EXPECT_EQ(none.due(kStart, 0s), kStart);
  EXPECT_EQ(none.due(kStart + 1ms, 1s), kStart + 1ms);
}

TEST(PacingTest, ALittleDelayIsMadeUpForAndALongOneIsNot) {
  Pacing pacing(1);
  EXPECT_EQ(pacing.due(kStart, 0s), kStart);
  EXPECT_EQ(pacing.due(kStart + 2040ms, 40ms), kStart + 40ms);
  EXPECT_EQ(pacing.due(kStart + 2081ms, 80ms), kStart + 2081ms);
  EXPECT_EQ(pacing.due(kStart + 2090ms, 120ms), kStart + 2121ms);
}

TEST(PacingTest, DamagedTimesDoNotStopIt) {
  Pacing pacing(1);
  EXPECT_EQ(pacing.due(kStart, 5s), kStart);
  EXPECT_EQ(pacing.due(kStart, 1s), kStart);         // back, as at the end of a loop
  EXPECT_EQ(pacing.due(kStart, 11s), kStart + 10s);  // the longest gap
  EXPECT_EQ(pacing.due(kStart, 1000h), kStart + 20s);
  Pacing slowest(1e-9);
  EXPECT_EQ(slowest.due(kStart, 0s), kStart);
  EXPECT_GT(slowest.due(kStart, 10s), kStart + 8000h);
}

}  // namespace pacing_test
}  // namespace rack::device
