#include "tests/bench/metrics.h"

#include <gtest/gtest.h>

namespace tims::bench {
namespace metrics_test {

TEST(Metrics, OtherLinesAreNotMetrics) {
  const Metrics metrics = parse_metrics("ready\nmetric p50_us 12.5\nmetric\nwarning 7\n");
  EXPECT_EQ(metrics, (Metrics{{"p50_us", 12.5}}));
}

TEST(Metrics, TheSlowestSubscriberCountsAndLossesAddUp) {
  const Metrics joined =
      join({{{"msgs_per_s", 100}, {"lost", 1}}, {{"msgs_per_s", 80}, {"lost", 2}}}, 2, 1);
  EXPECT_EQ(joined.at("msgs_per_s"), 80);
  EXPECT_EQ(joined.at("lost"), 3);
}

TEST(Metrics, RatesOfPairsAddUp) {
  const Metrics joined = join({{{"msgs_per_s", 100}}, {{"msgs_per_s", 80}}}, 1, 2);
  EXPECT_EQ(joined.at("msgs_per_s"), 180);
}

TEST(Metrics, CostsArePerMillionMessages) {
  const Metrics source{{raw::kCpu, 0.5}, {raw::kSleeps, 10}};
  const Metrics sink{{raw::kCpu, 1.5}, {raw::kSleeps, 30}, {raw::kCount, 4e6}};
  const Metrics joined = join({source, sink}, 1, 1);
  EXPECT_DOUBLE_EQ(joined.at("cpu_s"), 0.5);
  EXPECT_DOUBLE_EQ(joined.at("sleeps_per_million"), 10);
  EXPECT_FALSE(joined.contains(raw::kCpu));
}

TEST(Metrics, EightSubscribersOfOneMessageAreOneMessage) {
  const Metrics sink{{raw::kCpu, 1}, {raw::kCount, 1e6}};
  EXPECT_DOUBLE_EQ(join({sink, sink}, 2, 1).at("cpu_s"), 2);
}

TEST(Metrics, BytesOfADeviceAreTheFirstNumberAfterItsName) {
  const std::string text =
      "Inter-|   Receive           |  Transmit\n"
      " face |bytes    packets errs|bytes    packets\n"
      "    lo:     120       2    0      120       2\n"
      " cable:    4096      17    0      999       9\n";
  EXPECT_EQ(received_bytes(text, "cable"), 4096);
  EXPECT_EQ(received_bytes(text, "eth0"), 0);
}

TEST(Metrics, MedianOfEvenAndOdd) {
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 2, 3}), 2.5);
  EXPECT_EQ(median({}), 0);
}

TEST(Metrics, AMetricMissingInOneRepetitionIsTheMedianOfTheOthers) {
  const Metrics result = medians({{{"a", 1}, {"b", 5}}, {{"a", 3}}, {{"a", 2}}});
  EXPECT_EQ(result, (Metrics{{"a", 2}, {"b", 5}}));
}

}  // namespace metrics_test
}  // namespace tims::bench
