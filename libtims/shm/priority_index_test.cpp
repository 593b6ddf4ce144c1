#include "shm/priority_index.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace tims::shm {
namespace {

TEST(PriorityIndex, AgreesWithAStableSort) {
  std::mt19937 random(1);
  for (int round = 0; round < 200; ++round) {
    PriorityIndex index(64);
    std::vector<Hint> model;
    for (std::uint32_t i = 0; i < 64; ++i) {
      const Hint hint{.generation = i,
                      .priority = static_cast<std::uint8_t>(random() % (round + 1))};
      index.put(hint);
      model.push_back(hint);
    }
    EXPECT_TRUE(index.full());
    std::stable_sort(model.begin(), model.end(),
                     [](Hint a, Hint b) { return a.priority > b.priority; });
    for (const Hint& expected : model) {
      EXPECT_EQ(index.front().generation, expected.generation);
      index.pop();
    }
    EXPECT_TRUE(index.empty());
  }
}

TEST(PriorityIndex, PutBackGoesInFrontOfItsEquals) {
  PriorityIndex index(4);
  index.put({.generation = 1, .priority = 7});
  index.put_back({.generation = 2, .priority = 7});
  index.put({.generation = 3, .priority = 7});
  for (std::uint32_t expected : {2U, 1U, 3U}) {
    EXPECT_EQ(index.front().generation, expected);
    index.pop();
  }
}

TEST(PriorityIndex, RetainKeepsTheOrder) {
  PriorityIndex index(8);
  for (std::uint32_t i = 0; i < 8; ++i)
    index.put({.generation = i, .priority = static_cast<std::uint8_t>(i % 2)});
  index.retain([](Hint hint) { return hint.generation >= 4; });
  for (std::uint32_t expected : {5U, 7U, 4U, 6U}) {
    EXPECT_EQ(index.front().generation, expected);
    index.pop();
  }
  EXPECT_TRUE(index.empty());
}

}  // namespace
}  // namespace tims::shm
