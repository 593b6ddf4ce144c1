#include "tools/evaluation/dora/judgement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::dora {
namespace judgement_test {

using namespace std::chrono_literals;
using testing::HasSubstr;

std::vector<Time> every(Duration period, int count) {
  std::vector<Time> times;
  times.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) times.push_back(Time(1s) + i * period);
  return times;
}

const PeriodLimits kScans{.name = "Scan2d(1/0)", .period_ms = 1000.0 / 75};
const TimerQuality kGood{.source = "timer loop", .p99 = 20, .p999 = 50, .max = 90, .wakeups = 1000};
const TimerQuality kBad{.source = "timer loop", .p99 = 20, .p999 = 2000, .max = 90000};
const Reference kGoodMachine{.timer = kGood, .terminal = kGood};
const Reference kBadMachine{.timer = kBad, .terminal = kBad};

TEST(PeriodTest, RegularMessagesHold) {
  const std::vector<std::vector<Time>> spans{every(1000000000ns / 75, 1000)};
  EXPECT_EQ(judge_period(kScans, spans, kGoodMachine).verdict, Verdict::kHeld);
}

TEST(PeriodTest, AWrongMeanFailsOnAnyMachine) {
  const std::vector<std::vector<Time>> spans{every(13400us, 1000)};
  EXPECT_EQ(judge_period(kScans, spans, kBadMachine).verdict, Verdict::kFailed);
}

TEST(PeriodTest, TwoDeviationsInAThousandAreTooMany) {
  std::vector<std::vector<Time>> spans{every(1000000000ns / 75, 1000)};
  spans[0][500] += 1ms;  // two gaps: a longer one, a shorter one
  EXPECT_EQ(judge_period(kScans, spans, kGoodMachine).verdict, Verdict::kFailed);
  EXPECT_EQ(judge_period(kScans, spans, kBadMachine).verdict, Verdict::kMachine);
  spans[0].resize(400);
  EXPECT_EQ(judge_period(kScans, spans, kGoodMachine).verdict, Verdict::kHeld);
}

TEST(PeriodTest, SerialDataIsJudgedByTheTerminal) {
  std::vector<std::vector<Time>> spans{every(1000000000ns / 75, 1000)};
  spans[0][500] += 1ms;
  PeriodLimits limits = kScans;
  limits.from_a_line = true;
  const Reference bad_terminal{.timer = kGood, .terminal = kBad};
  const Reference bad_timer{.timer = kBad, .terminal = kGood};
  EXPECT_EQ(judge_period(limits, spans, bad_terminal).verdict, Verdict::kMachine);
  EXPECT_EQ(judge_period(limits, spans, bad_timer).verdict, Verdict::kFailed);
  EXPECT_EQ(judge_period(kScans, spans, bad_terminal).verdict, Verdict::kFailed);
}

TEST(PeriodTest, IntervalsBetweenTwoSpansDoNotCount) {
  std::vector<std::vector<Time>> spans{every(1000000000ns / 75, 300),
                                       every(1000000000ns / 75, 300)};
  for (Time& time : spans[1]) time += 5min;
  EXPECT_EQ(judge_period(kScans, spans, kGoodMachine).verdict, Verdict::kHeld);
}

TEST(PeriodTest, SilenceIsAFailure) {
  const std::vector<std::vector<Time>> spans{every(1s, 2)};
  const Row row = judge_period(kScans, spans, kBadMachine);
  EXPECT_EQ(row.verdict, Verdict::kFailed);
  EXPECT_THAT(row.measured, HasSubstr("1 intervals received"));
}

TEST(LatencyTest, BothLimitsCount) {
  const LatencyLimits limits{.check = "b", .what = "stop", .look = "", .p99_ms = 68, .max_ms = 80};
  std::vector<double> ms(200, 50);
  EXPECT_EQ(judge_latency(limits, ms, kGood).verdict, Verdict::kHeld);
  ms[0] = 79;
  EXPECT_EQ(judge_latency(limits, ms, kGood).verdict, Verdict::kHeld);
  ms[0] = 81;
  EXPECT_EQ(judge_latency(limits, ms, kGood).verdict, Verdict::kFailed);
  EXPECT_EQ(judge_latency(limits, ms, kBad).verdict, Verdict::kMachine);
  for (int i = 0; i < 4; ++i) ms[static_cast<std::size_t>(i)] = 70;
  EXPECT_EQ(judge_latency(limits, ms, kGood).verdict, Verdict::kFailed);
  EXPECT_EQ(judge_latency(limits, {}, kBad).verdict, Verdict::kFailed) << "it was not observed";
}

TEST(AmountTest, ItsQuantileCounts) {
  const AmountLimit limits{.check = "d", .what = "beside", .look = "", .unit = "mm", .most = 150};
  std::vector<double> values(100, 100);
  std::fill_n(values.begin(), 4, 1000);
  EXPECT_EQ(judge_amount(limits, values).verdict, Verdict::kHeld);
  std::fill_n(values.begin(), 7, 1000);
  EXPECT_EQ(judge_amount(limits, values).verdict, Verdict::kFailed);
  EXPECT_EQ(judge_amount(limits, {}).verdict, Verdict::kFailed);
}

TEST(TableTest, AFailureNamesWhereToLookAndExitsWithOne) {
  std::vector<Row> rows{judge_fact("g", "unplugged", "it stops", "it stops", true, "nothing"),
                        left_out("c", "obstacles", "needs --for 2min")};
  EXPECT_EQ(exit_status(rows), 0);
  rows.push_back(judge_latency({.check = "f", .what = "killed", .look = "", .max_ms = 200},
                               std::vector<double>{300}, {.max = 150000}));
  EXPECT_EQ(exit_status(rows), 3);
  EXPECT_THAT(table(rows, kBadMachine, false),
              HasSubstr("the timers of this machine are too late"));
  rows.push_back(judge_fact("g", "plugged", "it goes on", "it stands", false, "the ladar's log"));
  EXPECT_EQ(exit_status(rows), 1);
  const std::string text = table(rows, kGoodMachine, false);
  EXPECT_THAT(text, HasSubstr("see: the ladar's log"));
  EXPECT_THAT(text, testing::Not(HasSubstr("see: nothing")));
  EXPECT_THAT(to_json(rows, kGoodMachine), HasSubstr(R"("verdict":"left out")"));
}

TEST(TimerTest, Histogram) {
  WakeupHistogram histogram;
  for (int i = 0; i < 998; ++i) histogram.add(10);
  histogram.add(700);
  histogram.add(1e6);
  const TimerQuality quality = histogram.quality("timer loop", true);
  EXPECT_EQ(quality.p99, 10);
  EXPECT_EQ(quality.p999, 700);
  EXPECT_EQ(quality.max, 1e6);
}

TEST(TimerTest, ParsesTheOutputOfCyclictest) {
  const auto quality = parse_cyclictest(
      "# /dev/cpu_dma_latency set to 0us\n# Histogram\n000000 000000\n000013 000990\n000100 "
      "000009\n"
      "# Total: 000001000\n# Min Latencies: 00013\n# Max Latencies: 25000\n"
      "# Histogram Overflows: 00001\n");
  ASSERT_TRUE(quality);
  EXPECT_EQ(quality->wakeups, 1000);
  EXPECT_EQ(quality->p99, 13);
  EXPECT_EQ(quality->p999, 100);
  EXPECT_EQ(quality->max, 25000);
  EXPECT_FALSE(parse_cyclictest("FATAL: Operation not permitted\n"));
}

}  // namespace judgement_test
}  // namespace rack::dora
