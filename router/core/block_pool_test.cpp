#include "router/core/block_pool.h"

#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace tims::core {
namespace {

TEST(BlockPool, HandsOutEachBlockOnce) {
  std::vector<std::byte> memory(3 * BlockPool::kBlockSize + 100);
  BlockPool pool(memory);
  EXPECT_EQ(pool.available(), 3U);
  const std::set<BlockPool::Index> blocks{pool.allocate(), pool.allocate(), pool.allocate()};
  EXPECT_EQ(blocks.size(), 3U);
  EXPECT_FALSE(blocks.contains(BlockPool::kNone));
  EXPECT_EQ(pool.allocate(), BlockPool::kNone);
  EXPECT_EQ(pool.used(), 3U);
}

TEST(BlockPool, UsesTheBlockReleasedLastFirst) {
  std::vector<std::byte> memory(8 * BlockPool::kBlockSize);
  BlockPool pool(memory);
  const auto first = pool.allocate();
  const auto second = pool.allocate();
  pool.release(first);
  pool.release(second);
  EXPECT_EQ(pool.allocate(), second);
  EXPECT_EQ(pool.allocate(), first);
  EXPECT_EQ(pool.touched_bytes(), 2 * BlockPool::kBlockSize);
}

TEST(BlockPool, StartsAnewWhenItForgets) {
  std::vector<std::byte> memory(2 * BlockPool::kBlockSize);
  BlockPool pool(memory);
  pool.release(pool.allocate());
  pool.forget();
  EXPECT_EQ(pool.touched_bytes(), 0U);
  EXPECT_NE(pool.allocate(), BlockPool::kNone);
  EXPECT_NE(pool.allocate(), BlockPool::kNone);
  EXPECT_EQ(pool.allocate(), BlockPool::kNone);
}

TEST(BlockPool, MayHaveNoMemoryAtAll) {
  BlockPool pool({});
  EXPECT_EQ(pool.allocate(), BlockPool::kNone);
}

}  // namespace
}  // namespace tims::core
