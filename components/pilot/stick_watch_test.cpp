#include "components/pilot/stick_watch.h"

#include <gtest/gtest.h>

namespace rack::pilot {
namespace stick_watch_test {

using namespace std::chrono_literals;

constexpr tims::Time kStart{1000s};

TEST(StickWatch, AStickOnThisHostIsNeverStopped) {
  StickWatch watch(300ms, 100ms);
  EXPECT_FALSE(watch.must_stand(kStart)) << "before the first position";
  watch.heard(kStart, false);
  EXPECT_FALSE(watch.must_stand(kStart + 900ms));
}

TEST(StickWatch, TheVehicleStandsBeforeARemoteStickIsSilentForTooLong) {
  StickWatch watch(300ms, 100ms);
  watch.heard(kStart, true);
  EXPECT_FALSE(watch.must_stand(kStart));
  EXPECT_FALSE(watch.must_stand(kStart + 200ms)) << "the next look is at 300 ms";
  EXPECT_TRUE(watch.must_stand(kStart + 201ms));
  EXPECT_TRUE(watch.must_stand(kStart + 5s));
}

// Whatever the phase of the looks: the command to stand is sent within the time.
TEST(StickWatch, KeepsItsTimeAtEveryPhase) {
  for (auto phase = 0ms; phase < 100ms; phase += 1ms) {
    StickWatch watch(300ms, 100ms);
    watch.heard(kStart, true);
    auto look = kStart + phase;
    while (!watch.must_stand(look)) look += 100ms;
    EXPECT_LE(look - kStart, 300ms) << phase.count();
  }
}

TEST(StickWatch, AStickThatIsHeardAgainDrivesAgain) {
  StickWatch watch(300ms, 100ms);
  watch.heard(kStart, true);
  EXPECT_TRUE(watch.must_stand(kStart + 1s));
  watch.heard(kStart + 1s, true);
  EXPECT_FALSE(watch.must_stand(kStart + 1s));
  watch.heard(kStart + 2s, false);
  EXPECT_FALSE(watch.must_stand(kStart + 3s)) << "it is on this host now";
}

}  // namespace stick_watch_test
}  // namespace rack::pilot
