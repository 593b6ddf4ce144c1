#include "tools/robot/flood_gate.h"

#include <gtest/gtest.h>

namespace timsctl::robot {
namespace flood_gate_test {

using namespace std::chrono_literals;

constexpr tims::Time kStart{1000s};

TEST(FloodGate, ManyLinesAtOncePassAndNoMore) {
  FloodGate gate;
  EXPECT_EQ(gate.pass(kStart, kLinesAtOnce - 1), kLinesAtOnce - 1);
  EXPECT_TRUE(gate.pass(kStart));
  EXPECT_FALSE(gate.is_cut());
  EXPECT_EQ(gate.report_at(), tims::kNever);
  EXPECT_FALSE(gate.pass(kStart));
  EXPECT_TRUE(gate.is_cut());
}

TEST(FloodGate, ANormalRatePassesForEver) {
  FloodGate gate;
  for (int second = 0; second < 100; ++second)
    ASSERT_EQ(gate.pass(kStart + second * 1s, kLinesPerSecond), kLinesPerSecond) << second;
}

TEST(FloodGate, AFloodIsCountedAndReportedNowAndThen) {
  FloodGate gate;
  std::uint64_t passed = 0;
  std::uint64_t reported = 0;
  int reports = 0;
  constexpr int kSeconds = 60;
  constexpr std::uint64_t kEach = 1000;  // every 10 ms
  for (int i = 0; i < kSeconds * 100; ++i) {
    const tims::Time now = kStart + i * 10ms;
    passed += gate.pass(now, kEach);
    if (const auto held_back = gate.take_report(now)) {
      reported += *held_back;
      ++reports;
    }
  }
  EXPECT_LE(passed, kLinesAtOnce + kLinesPerSecond);
  EXPECT_GE(reports, kSeconds / 10 - 1);
  EXPECT_LE(reports, kSeconds / 10 + 1);
  const auto rest = gate.take_report(kStart + 100s);
  EXPECT_EQ(passed + reported + rest.value_or(0), kEach * kSeconds * 100);
}

TEST(FloodGate, OpensWhenTheFloodIsOver) {
  FloodGate gate;
  EXPECT_EQ(gate.pass(kStart, 2 * kLinesAtOnce), kLinesAtOnce);
  EXPECT_FALSE(gate.take_report(kStart + 999ms));
  EXPECT_EQ(gate.take_report(kStart + 1s), kLinesAtOnce);
  EXPECT_EQ(gate.report_at(), tims::kNever);
  EXPECT_TRUE(gate.pass(kStart + 3s)) << "a quiet second has passed";
}

TEST(FloodGate, StaysClosedForARateAboveTheLimit) {
  FloodGate gate;
  (void)gate.pass(kStart, kLinesAtOnce + 1);
  EXPECT_EQ(gate.pass(kStart + 500ms, kLinesPerSecond + 1), 0U);
  EXPECT_EQ(gate.pass(kStart + 1s, kLinesPerSecond), 0U) << "too many in the last second";
  EXPECT_TRUE(gate.pass(kStart + 2s)) << "not more than allowed in the last second";
}

}  // namespace flood_gate_test
}  // namespace timsctl::robot
