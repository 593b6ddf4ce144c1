#include "components/runtime/logic/repeats.h"

#include <string>

#include <gtest/gtest.h>

namespace rack {
namespace repeats_test {

using namespace std::chrono_literals;

constexpr tims::Time kRepeatsStart{1000s};
constexpr tims::Header kMove{.type = 21, .src = tims::Address(0x00300001)};

TEST(WithoutNumbers, TextsThatDifferInTheirNumbersAreTheSame) {
  EXPECT_EQ(without_numbers("data of time 9 ms"), without_numbers("data of time 1234 ms"));
  EXPECT_NE(without_numbers("data of time 9 ms"), without_numbers("data of time ms"));
  EXPECT_NE(without_numbers("1 a 2"), without_numbers("1 b 2"));
}

TEST(RefusalLog, WritesOnceAndThenTheCount) {
  RefusalLog log;
  EXPECT_TRUE(log.take(kRepeatsStart, kMove, "not the active pilot").write);
  for (int i = 1; i < 600; ++i)
    ASSERT_FALSE(log.take(kRepeatsStart + i * 100ms, kMove, "not the active pilot").write) << i;
  const auto later = log.take(kRepeatsStart + 60s, kMove, "not the active pilot");
  EXPECT_TRUE(later.write);
  EXPECT_EQ(later.repeats, 599U);
}

TEST(RefusalLog, OtherSendersCommandsAndReasonsAreNew) {
  RefusalLog log;
  tims::Header other = kMove;
  other.src = tims::Address(0x00300002);
  tims::Header reset = kMove;
  reset.type = 22;
  EXPECT_TRUE(log.take(kRepeatsStart, kMove, "off").write);
  EXPECT_TRUE(log.take(kRepeatsStart, other, "off").write);
  EXPECT_TRUE(log.take(kRepeatsStart, reset, "off").write);
  EXPECT_TRUE(log.take(kRepeatsStart, kMove, "too fast").write);
  EXPECT_FALSE(log.take(kRepeatsStart, kMove, "off").write);
}

TEST(RefusalLog, ForgetsTheOldestOfManyReasons) {
  RefusalLog log;
  EXPECT_TRUE(log.take(kRepeatsStart, kMove, "first").write);
  for (int i = 0; i < 32; ++i)
    EXPECT_TRUE(log.take(kRepeatsStart + 1s, kMove, std::string(1U + i, 'x')).write) << i;
  EXPECT_TRUE(log.take(kRepeatsStart + 2s, kMove, "first").write);
  EXPECT_FALSE(log.take(kRepeatsStart + 2s, kMove, std::string(31, 'x')).write);
}

TEST(FailureLog, ASingleFailureAndTheOnAfterItAreWritten) {
  FailureLog log;
  EXPECT_TRUE(log.turned_on(kRepeatsStart));
  EXPECT_TRUE(log.failed("no data for 2000 ms"));
  EXPECT_TRUE(log.turned_on(kRepeatsStart + 3s));
  EXPECT_EQ(log.settled(kRepeatsStart + 13s), std::nullopt) << "it was written";
  EXPECT_TRUE(log.failed("no data for 2000 ms")) << "long after";
}

TEST(FailureLog, AFailureThatReturnsIsCounted) {
  FailureLog log;
  (void)log.turned_on(kRepeatsStart);
  EXPECT_TRUE(log.failed("not the active pilot"));
  EXPECT_TRUE(log.turned_on(kRepeatsStart + 3s));
  EXPECT_TRUE(log.failed("not the active pilot")) << "it has happened again";
  EXPECT_FALSE(log.turned_on(kRepeatsStart + 6s));
  for (int i = 3; i < 10; ++i) {
    EXPECT_FALSE(log.failed("not the active pilot"));
    EXPECT_FALSE(log.turned_on(kRepeatsStart + i * 3s));
    EXPECT_EQ(log.settled(kRepeatsStart + i * 3s + 2s), std::nullopt);
  }
  EXPECT_EQ(log.settled(kRepeatsStart + 27s + FailureLog::kSettled - 1ms), std::nullopt);
  EXPECT_EQ(log.settled(kRepeatsStart + 27s + FailureLog::kSettled), 7U);
  EXPECT_EQ(log.settled(kRepeatsStart + 60s), std::nullopt) << "written once";
  EXPECT_TRUE(log.failed("not the active pilot"));
}

TEST(FailureLog, TwoReasonsInTurnAreWrittenOnceEach) {
  FailureLog log;
  EXPECT_TRUE(log.failed("a"));
  EXPECT_TRUE(log.failed("b"));
  EXPECT_FALSE(log.failed("a"));
  EXPECT_FALSE(log.failed("b"));
  EXPECT_TRUE(log.turned_on(kRepeatsStart)) << "it was not on since";
  log.turned_off();
  EXPECT_TRUE(log.failed("a"));
}

}  // namespace repeats_test
}  // namespace rack
