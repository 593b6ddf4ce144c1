#include "components/devices/chassis/move_deadline.h"

#include <gtest/gtest.h>

namespace rack::device {
namespace move_deadline_test {

using namespace std::chrono_literals;

constexpr Time kBegin{1000s};

// Gives `count` commands and returns the time of the last one.
Time command(MoveDeadline& deadline, Duration period, int count, Time now = kBegin) {
  for (int i = 0; i < count; ++i) deadline.on_move(now += period);
  return now;
}

TEST(MoveDeadlineTest, ThreePeriodsOfItsSender) {
  for (const Duration period : {20ms, 50ms, 100ms, 333ms}) {
    MoveDeadline deadline;
    const Time last = command(deadline, period, 4);
    EXPECT_TRUE(deadline.holds());
    EXPECT_EQ(deadline.due(), last + 3 * period);
  }
}

TEST(MoveDeadlineTest, AnUnknownPeriodPermitsThreeTenthsOfASecond) {
  MoveDeadline deadline;
  EXPECT_EQ(deadline.due(), tims::kNever);
  const Time last = command(deadline, 20ms, 3);
  EXPECT_EQ(deadline.due(), last + 300ms);
}

TEST(MoveDeadlineTest, NeitherTooShortNorTooLong) {
  MoveDeadline fast;
  command(fast, 1ms, 10);
  EXPECT_EQ(fast.length(), 50ms);
  MoveDeadline slow;
  command(slow, 900ms, 10);
  EXPECT_EQ(slow.length(), 1s);
}

TEST(MoveDeadlineTest, AfterABreakItIsLearntAgain) {
  MoveDeadline deadline;
  const Time last = command(deadline, 20ms, 10);
  deadline.on_move(last + 5s);
  EXPECT_EQ(deadline.length(), 300ms);
}

TEST(MoveDeadlineTest, EndingKeepsThePeriodAndForgettingDoesNot) {
  MoveDeadline deadline;
  command(deadline, 50ms, 10);
  deadline.end();
  EXPECT_EQ(deadline.due(), tims::kNever);
  EXPECT_EQ(deadline.length(), 150ms);
  deadline.forget();
  EXPECT_EQ(deadline.length(), 300ms);
}

TEST(MoveDeadlineTest, ATimeThatIsSet) {
  MoveDeadline deadline(10s);
  EXPECT_EQ(deadline.due(), tims::kNever);
  const Time last = command(deadline, 20ms, 10);
  EXPECT_EQ(deadline.due(), last + 10s);
}

}  // namespace move_deadline_test
}  // namespace rack::device
