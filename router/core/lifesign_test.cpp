#include "router/core/lifesign.h"

#include <gtest/gtest.h>

namespace tims::core {
namespace {

using namespace std::chrono_literals;
using Beat = Lifesigns::Beat;

class LifesignsTest : public testing::Test {
 protected:
  const Time start_{1000s};
  Lifesigns lifesigns_{5s};
  Client client_;
  Client other_;
};

TEST_F(LifesignsTest, BeatOnlyWhileSomebodyIsWatched) {
  EXPECT_EQ(lifesigns_.next_beat(), kNever);
  lifesigns_.watch(start_, client_);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 5s);
  lifesigns_.watch(start_ + 1s, client_);
  lifesigns_.watch(start_ + 1s, other_);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 5s);
  lifesigns_.unwatch(client_);
  lifesigns_.unwatch(client_);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 5s);
  lifesigns_.unwatch(other_);
  EXPECT_EQ(lifesigns_.next_beat(), kNever);
  EXPECT_EQ(lifesigns_.beat(start_ + 60s), Beat::kNotYet);
}

TEST_F(LifesignsTest, KeepsItsRhythm) {
  lifesigns_.watch(start_, client_);
  EXPECT_EQ(lifesigns_.beat(start_ + 4999ms), Beat::kNotYet);
  EXPECT_EQ(lifesigns_.beat(start_ + 5003ms), Beat::kAsk);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 10s);
}

TEST_F(LifesignsTest, ALateBeatIsKnownAsSuchAndStartsANewRhythm) {
  lifesigns_.watch(start_, client_);
  EXPECT_EQ(lifesigns_.beat(start_ + 20s), Beat::kLate);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 25s);
}

TEST_F(LifesignsTest, WatchingAndUnwatchingClearTheMark) {
  lifesigns_.watch(start_, client_);
  client_.owes_answer = true;
  lifesigns_.watch(start_, client_);
  EXPECT_FALSE(client_.owes_answer);
  client_.owes_answer = true;
  lifesigns_.unwatch(client_);
  EXPECT_FALSE(client_.owes_answer);
}

TEST_F(LifesignsTest, ALongerIntervalHoldsFromTheNextBeatOn) {
  lifesigns_.watch(start_, client_);
  lifesigns_.set_interval(start_, 60s);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 5s);
  EXPECT_EQ(lifesigns_.beat(start_ + 5s), Beat::kAsk);
  EXPECT_EQ(lifesigns_.next_beat(), start_ + 65s);
}

}  // namespace
}  // namespace tims::core
