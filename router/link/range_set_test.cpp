#include "router/link/range_set.h"

#include <cstdint>
#include <set>

#include <gtest/gtest.h>

namespace tims::link {
namespace {

using Ranges = std::vector<Range>;

TEST(RangeSet, JoinsWhatTouches) {
  RangeSet set;
  EXPECT_TRUE(set.add({10, 20}));
  EXPECT_TRUE(set.add({30, 40}));
  EXPECT_EQ(set.ranges(), (Ranges{{10, 20}, {30, 40}}));
  EXPECT_TRUE(set.add({20, 30}));
  EXPECT_EQ(set.ranges(), (Ranges{{10, 40}}));
  EXPECT_TRUE(set.add({0, 9}));
  EXPECT_EQ(set.ranges(), (Ranges{{0, 9}, {10, 40}}));
}

TEST(RangeSet, AnEmptyRangeIsNothing) {
  RangeSet set;
  EXPECT_TRUE(set.add({5, 5}));
  EXPECT_TRUE(set.empty());
  EXPECT_TRUE(set.contains({5, 5}));
}

TEST(RangeSet, HoldsSoManyAndNoMore) {
  RangeSet set;
  for (std::uint64_t i = 0; i < RangeSet::kRangesMax; ++i)
    ASSERT_TRUE(set.add({10 * i, 10 * i + 5}));
  const Ranges full = set.ranges();
  EXPECT_FALSE(set.add({1'000'000, 1'000'001}));
  EXPECT_EQ(set.ranges(), full);
  EXPECT_TRUE(set.add({5, 10}));  // joins two
  EXPECT_TRUE(set.add({1'000'000, 1'000'001}));
}

TEST(RangeSet, RemovesFromTheMiddle) {
  RangeSet set;
  set.add({0, 100});
  set.remove({40, 60});
  EXPECT_EQ(set.ranges(), (Ranges{{0, 40}, {60, 100}}));
  set.remove_below(70);
  EXPECT_EQ(set.ranges(), (Ranges{{70, 100}}));
  set.remove_below(100);
  EXPECT_TRUE(set.empty());
}

// Against a set of single numbers.
TEST(RangeSet, IsASetOfNumbers) {
  RangeSet set;
  std::set<std::uint64_t> model;
  std::uint64_t state = 1;
  const auto random = [&](std::uint64_t below) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return (state >> 33) % below;
  };
  for (int i = 0; i < 20'000; ++i) {
    const std::uint64_t begin = random(300);
    const Range range{begin, begin + random(20)};
    if (random(3) == 0) {
      set.remove(range);
      for (auto n = range.begin; n < range.end; ++n) model.erase(n);
    } else if (set.add(range)) {
      for (auto n = range.begin; n < range.end; ++n) model.insert(n);
    }
    std::uint64_t size = 0;
    for (const Range& r : set.ranges()) size += r.size();
    ASSERT_EQ(size, model.size()) << "step " << i;
    bool all = true;
    std::uint64_t missing = range.end;
    for (auto n = range.end; n-- > range.begin;) {
      if (model.contains(n)) continue;
      all = false;
      missing = n;
    }
    ASSERT_EQ(set.contains(range), all) << "step " << i;
    const auto first = set.first_missing(range);
    ASSERT_EQ(first.has_value(), !all);
    if (first) {
      ASSERT_EQ(first->begin, missing);
    }
  }
}

}  // namespace
}  // namespace tims::link
