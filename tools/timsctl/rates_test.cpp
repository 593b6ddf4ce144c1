#include "tools/timsctl/rates.h"

#include <array>

#include <boost/json/parse.hpp>
#include <gtest/gtest.h>

namespace timsctl {
namespace rates_test {

using namespace std::chrono_literals;

tims::Time at(tims::Duration since) { return tims::Time(since); }

TEST(RateMeter, AnEvenStream) {
  RateMeter meter(at(0ms));
  for (int i = 1; i <= 10; ++i) meter.on_message(at(i * 100ms), 50, 3);
  const RateReport report = meter.report(at(1000ms));
  ASSERT_TRUE(report.intervals);
  EXPECT_NEAR(report.intervals->rate_hz, 10, 1e-9);
  EXPECT_NEAR(report.intervals->std_s, 0, 1e-9);
  EXPECT_NEAR(report.intervals->jitter_s, 0, 1e-9);
  EXPECT_EQ(report.messages, 10U);
  EXPECT_DOUBLE_EQ(report.bytes_per_s, 500);
  EXPECT_FALSE(report.lost) << "the same number in every message: nobody counts";
}

TEST(RateMeter, AnUnevenStream) {
  RateMeter meter(at(0ms));
  for (const auto time : {100ms, 200ms, 500ms}) meter.on_message(at(time), 1, 0);
  const auto intervals = meter.report(at(1s)).intervals;
  ASSERT_TRUE(intervals);
  EXPECT_NEAR(intervals->rate_hz, 5, 1e-9);
  EXPECT_NEAR(intervals->min_s, 0.1, 1e-9);
  EXPECT_NEAR(intervals->max_s, 0.3, 1e-9);
  EXPECT_NEAR(intervals->std_s, 0.1, 1e-9);
  EXPECT_NEAR(intervals->jitter_s, 0.1, 1e-9) << "one change of 200 ms in two intervals";
}

TEST(RateMeter, CountsWhatIsMissing) {
  RateMeter meter(at(0ms));
  constexpr std::array<std::uint8_t, 4> kNumbers = {254, 255, 0, 3};
  for (std::size_t i = 0; i < kNumbers.size(); ++i) meter.on_message(at(1ms * i), 1, kNumbers[i]);
  EXPECT_EQ(meter.report(at(1s)).lost, 2U);
}

TEST(RateMeter, SizesAreOfTheLastWindow) {
  RateMeter meter(at(0ms));
  meter.on_message(at(1ms), 10, 0);
  (void)meter.report(at(1s));
  meter.on_message(at(1100ms), 20, 0);
  meter.on_message(at(1200ms), 40, 0);
  const RateReport report = meter.report(at(2s));
  EXPECT_EQ(report.body_min_bytes, 20U);
  EXPECT_EQ(report.body_max_bytes, 40U);
  EXPECT_DOUBLE_EQ(report.body_mean_bytes, 30);
  EXPECT_EQ(report.messages_total, 3U);
}

TEST(RateMeter, AStreamSlowerThanTheReportsKeepsItsRate) {
  RateMeter meter(at(0s));
  for (int i = 0; i < 3; ++i) meter.on_message(at(i * 3s), 1, 0);
  (void)meter.report(at(6s));
  const RateReport between = meter.report(at(7s));
  ASSERT_TRUE(between.intervals);
  EXPECT_NEAR(between.intervals->rate_hz, 1.0 / 3, 1e-9);
  EXPECT_EQ(between.messages, 0U);
}

TEST(RateMeter, AStreamThatStoppedHasNoRate) {
  RateMeter meter(at(0s));
  for (int i = 1; i <= 5; ++i) meter.on_message(at(i * 10ms), 1, 0);
  EXPECT_TRUE(meter.report(at(1s)).intervals);
  const RateReport later = meter.report(at(5s));
  EXPECT_FALSE(later.intervals);
  EXPECT_NEAR(*later.silent_s, 4.95, 1e-9);
}

TEST(RateMeter, NothingYet) {
  RateMeter meter(at(0s));
  const RateReport report = meter.report(at(1s));
  EXPECT_FALSE(report.intervals);
  EXPECT_FALSE(report.silent_s);
  EXPECT_EQ(report.bytes_per_s, 0);
}

using namespace std::chrono_literals;

std::span<const json::value> span(const json::value& value) {
  return {value.get_array().data(), value.get_array().size()};
}

TEST(TopRates, AreDifferencesOverTime) {
  TopRates rates;
  const auto before = json::parse(R"([{"id": 1, "in_messages": 100, "out_bytes": 0}])");
  const auto boxes_before = json::parse(R"([{"owner": {"client": 1}, "received": 10}])");
  const json::array first = rates.update(tims::Time(10s), span(before), span(boxes_before));
  EXPECT_FALSE(number_at(first[0].as_object(), "in_per_s")) << "one sample is no rate";

  const auto after = json::parse(
      R"([{"id": 1, "in_messages": 150, "out_bytes": 4096}, {"id": 2, "in_messages": 9}])");
  const auto boxes = json::parse(R"([{"owner": {"client": 1}, "received": 20},
                                     {"owner": {"client": 1}, "received": 6}])");
  const json::array second = rates.update(tims::Time(12s), span(after), span(boxes));
  EXPECT_EQ(number_at(second[0].as_object(), "in_per_s"), 25);
  EXPECT_EQ(number_at(second[0].as_object(), "out_bytes_per_s"), 2048);
  EXPECT_EQ(number_at(second[0].as_object(), "taken_per_s"), 8);
  EXPECT_FALSE(number_at(second[1].as_object(), "in_per_s")) << "new";
}

TEST(TopRates, CountersThatGoWithAMailboxAreNoNegativeRate) {
  TopRates rates;
  const auto client = json::parse(R"([{"id": 1}])");
  const auto box = json::parse(R"([{"owner": {"client": 1}, "received": 10}])");
  (void)rates.update(tims::Time(1s), span(client), span(box));
  const json::array items = rates.update(tims::Time(2s), span(client), {});
  EXPECT_EQ(number_at(items[0].as_object(), "taken_per_s"), 0);
}

}  // namespace rates_test
}  // namespace timsctl
