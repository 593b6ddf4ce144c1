#include "router/core/byte_chain.h"

#include <deque>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace tims::core {
namespace byte_chain_test {

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

std::vector<std::byte> numbered(std::size_t size, std::size_t from) {
  std::vector<std::byte> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>((from + i) % 251);
  return bytes;
}

std::vector<std::byte> contents(BlockPool& pool, const ByteChain& chain) {
  std::vector<std::span<const std::byte>> pieces(1000);
  pieces.resize(chain.gather(pool, pieces, 0));
  std::vector<std::byte> bytes;
  for (const auto& piece : pieces) bytes.insert(bytes.end(), piece.begin(), piece.end());
  return bytes;
}

class ByteChainTest : public testing::Test {
 protected:
  std::vector<std::byte> memory_ = std::vector<std::byte>(64 * BlockPool::kBlockSize);
  BlockPool pool_{memory_};
  ByteChain chain_;
};

TEST_F(ByteChainTest, KeepsBytesInOrderOverBlocks) {
  chain_.append(pool_, numbered(10, 0));
  chain_.append(pool_, numbered(9000, 10));
  EXPECT_EQ(contents(pool_, chain_), numbered(9010, 0));
  EXPECT_EQ(pool_.used(), 3U);
  chain_.drop(pool_, 5000);
  EXPECT_EQ(contents(pool_, chain_), numbered(4010, 5000));
  EXPECT_EQ(pool_.used(), 2U);
  chain_.drop(pool_, 4010);
  EXPECT_TRUE(chain_.empty());
  EXPECT_EQ(pool_.used(), 0U);
}

TEST_F(ByteChainTest, CountsTheBlocksThatMoreBytesTake) {
  EXPECT_EQ(chain_.blocks_needed(pool_, 1), 1U);
  EXPECT_EQ(chain_.blocks_needed(pool_, ByteChain::kBlockBytes), 1U);
  EXPECT_EQ(chain_.blocks_needed(pool_, ByteChain::kBlockBytes + 1), 2U);
  chain_.append(pool_, numbered(ByteChain::kBlockBytes - 1, 0));
  EXPECT_EQ(chain_.blocks_needed(pool_, 1), 0U);
  EXPECT_EQ(chain_.blocks_needed(pool_, 2), 1U);
}

TEST_F(ByteChainTest, PeeksOverTheEndOfABlock) {
  chain_.append(pool_, numbered(ByteChain::kBlockBytes + 20, 0));
  chain_.drop(pool_, ByteChain::kBlockBytes - 5);
  std::vector<std::byte> sixteen(16);
  chain_.peek(pool_, sixteen);
  EXPECT_EQ(sixteen, numbered(16, ByteChain::kBlockBytes - 5));
  EXPECT_EQ(contents(pool_, chain_).size(), 25U);
}

TEST_F(ByteChainTest, MovesItsFrontWithoutCopyingWholeBlocks) {
  chain_.append(pool_, numbered(10'000, 0));
  const std::byte* first = pool_.at(chain_.head);
  ByteChain to;
  BlockPool::Index spare = pool_.allocate();
  chain_.move_front(pool_, 6000, to, spare);
  EXPECT_EQ(contents(pool_, to), numbered(6000, 0));
  EXPECT_EQ(contents(pool_, chain_), numbered(4000, 6000));
  EXPECT_EQ(pool_.at(to.head), first);
  EXPECT_EQ(spare, BlockPool::kNone);
}

TEST_F(ByteChainTest, NeedsNoSpareWhenTheFrontEndsWithABlock) {
  chain_.append(pool_, numbered(2 * ByteChain::kBlockBytes, 0));
  ByteChain to;
  BlockPool::Index spare = pool_.allocate();
  chain_.move_front(pool_, ByteChain::kBlockBytes, to, spare);
  EXPECT_NE(spare, BlockPool::kNone);
  EXPECT_EQ(contents(pool_, to).size(), ByteChain::kBlockBytes);
}

TEST_F(ByteChainTest, BehavesAsADequeDoes) {
  std::mt19937 random(1);
  std::deque<std::byte> model;
  std::size_t next = 0;
  for (int step = 0; step < 5000; ++step) {
    if (model.size() < 100'000 && random() % 2 == 0) {
      const auto bytes = numbered(random() % 6000, next);
      next += bytes.size();
      chain_.append(pool_, bytes);
      model.insert(model.end(), bytes.begin(), bytes.end());
    } else if (!model.empty()) {
      const std::size_t n = random() % (model.size() + 1);
      chain_.drop(pool_, n);
      model.erase(model.begin(), model.begin() + static_cast<std::ptrdiff_t>(n));
    }
    ASSERT_EQ(contents(pool_, chain_), std::vector<std::byte>(model.begin(), model.end()));
  }
}

TEST_F(ByteChainTest, BytesInItsMiddleAreExchangedForAnyNumberOfOthers) {
  std::mt19937 random(2);
  std::vector<std::byte> model;
  for (int step = 0; step < 5000; ++step) {
    const auto bytes = numbered(random() % 9000, step);
    if (model.size() < 60'000) {
      chain_.append(pool_, bytes);
      model.insert(model.end(), bytes.begin(), bytes.end());
    } else {
      const std::size_t first = random() % 3000;
      chain_.drop(pool_, first);
      model.erase(model.begin(), model.begin() + static_cast<std::ptrdiff_t>(first));
    }
    if (model.empty()) continue;
    const std::size_t at = random() % model.size();
    const std::size_t size = std::min<std::size_t>(model.size() - at, random() % 9000);
    const auto place = ByteChain::advanced(pool_, chain_.front(pool_), at);
    std::vector<std::byte> shown(size);
    ByteChain::peek(pool_, place, shown);
    const auto begin = model.begin() + static_cast<std::ptrdiff_t>(at);
    ASSERT_TRUE(std::equal(shown.begin(), shown.end(), begin));
    const std::size_t before = pool_.used();
    chain_.replace(pool_, place, size, bytes);
    ASSERT_LE(pool_.used(), before + ByteChain::replace_blocks_max(bytes.size()));
    model.insert(model.erase(begin, begin + static_cast<std::ptrdiff_t>(size)), bytes.begin(),
                 bytes.end());
    ASSERT_EQ(contents(pool_, chain_), model) << "step " << step;
  }
  chain_.drop(pool_, model.size());
  EXPECT_EQ(pool_.used(), 0U);
  EXPECT_TRUE(chain_.empty());
}

}  // namespace byte_chain_test
}  // namespace tims::core
