#include "base/statistics.h"

#include <gtest/gtest.h>

namespace tims::base {
namespace statistics_test {

TEST(StatisticsTest, QuantilesAreValuesThatWereMeasured) {
  EXPECT_EQ(quantile({}, 0.5), 0);
  EXPECT_EQ(quantile({7}, 0.999), 7);
  EXPECT_EQ(quantile({3, 1, 2}, 0), 1);
  EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(quantile({3, 1, 2}, 1), 3);
  std::vector<double> many(1000);
  for (std::size_t i = 0; i < many.size(); ++i) many[i] = static_cast<double>(i);
  EXPECT_EQ(quantile(many, 0.95), 949);
}

TEST(StatisticsTest, Means) {
  EXPECT_EQ(mean({}), 0);
  EXPECT_EQ(mean(std::vector<double>{1, 2, 6}), 3);
}

}  // namespace statistics_test
}  // namespace tims::base
