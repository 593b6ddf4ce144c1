#include "tools/timsctl/top_rates.h"

#include <boost/json/parse.hpp>
#include <gtest/gtest.h>

namespace timsctl {
namespace {

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

}  // namespace
}  // namespace timsctl
