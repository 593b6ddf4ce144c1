#include "router/link/buffers.h"

#include <cstdint>
#include <deque>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace tims::link {
namespace buffers_test {

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

constexpr std::size_t kBlock = core::BlockPool::kBlockSize;

struct StreamBufferTest : testing::Test {
  alignas(kBlock) std::array<std::byte, 16 * kBlock> memory{};
  core::BlockPool pool{memory};
  StreamBuffer buffer{pool};

  void append(std::size_t size) {
    std::vector<std::byte> bytes(size);
    for (std::byte& b : bytes) b = static_cast<std::byte>(next++);
    buffer.append(bytes);
  }
  void expect_bytes() const {
    std::vector<std::byte> bytes(buffer.size());
    buffer.read(buffer.begin(), bytes);
    for (std::size_t i = 0; i < bytes.size(); ++i)
      ASSERT_EQ(bytes[i], static_cast<std::byte>(buffer.begin() + i));
  }
  std::uint64_t next = 0;
};

TEST_F(StreamBufferTest, GivesBackWhatIsFreedAnywhere) {
  append(4 * kBlock + 10);
  EXPECT_EQ(pool.used(), 5U);
  buffer.free({kBlock + 1, 3 * kBlock + 1});
  EXPECT_EQ(pool.used(), 4U) << "one byte of the second block is still needed";
  buffer.free({kBlock, kBlock + 1});
  EXPECT_EQ(pool.used(), 3U);
  buffer.free({4 * kBlock, 4 * kBlock + 10});
  EXPECT_EQ(pool.used(), 3U) << "it is not full";
  append(kBlock);
  EXPECT_EQ(pool.used(), 4U);
  buffer.free({4 * kBlock + 10, 5 * kBlock});
  EXPECT_EQ(pool.used(), 3U);
  std::vector<std::byte> bytes(10);
  buffer.read(5 * kBlock, bytes);
  for (std::size_t i = 0; i < bytes.size(); ++i)
    EXPECT_EQ(bytes[i], static_cast<std::byte>(5 * kBlock + i));
  buffer.free({0, kBlock});
  buffer.free({3 * kBlock + 1, 4 * kBlock});
  EXPECT_EQ(pool.used(), 1U);
  EXPECT_EQ(buffer.begin(), 5 * kBlock);
  expect_bytes();
  buffer.free({5 * kBlock, 5 * kBlock + 10});
  EXPECT_EQ(pool.used(), 0U);
  EXPECT_TRUE(buffer.empty());
  append(20);
  EXPECT_EQ(pool.used(), 1U);
  expect_bytes();
}

TEST_F(StreamBufferTest, GivesBackWhatItNoLongerNeeds) {
  append(3 * kBlock + 10);
  EXPECT_EQ(pool.used(), 4U);
  buffer.release_to(kBlock);
  EXPECT_EQ(pool.used(), 3U);
  buffer.release_to(3 * kBlock + 10);  // empty, in the middle of a block
  EXPECT_EQ(pool.used(), 0U);
  append(20);
  EXPECT_EQ(pool.used(), 1U);
  expect_bytes();
}

TEST_F(StreamBufferTest, KnowsWhetherThereIsRoom) {
  EXPECT_TRUE(buffer.has_room(16 * kBlock));
  EXPECT_FALSE(buffer.has_room(16 * kBlock + 1));
  append(1);
  EXPECT_TRUE(buffer.has_room(16 * kBlock - 1));
  EXPECT_FALSE(buffer.has_room(16 * kBlock));
}

TEST_F(StreamBufferTest, MovesItsFrontToAnother) {
  StreamBuffer other(pool);
  append(2 * kBlock + 100);
  buffer.move_front(kBlock + 50, other);
  EXPECT_EQ(other.size(), kBlock + 50);
  expect_bytes();
  std::array<std::byte, 1> last{};
  other.read(kBlock + 49, last);
  EXPECT_EQ(last[0], static_cast<std::byte>((kBlock + 49) % 256));
}

TEST_F(StreamBufferTest, RunsForLong) {
  for (std::size_t i = 0; i < 2000; ++i) {
    append(i * 37 % 5000);
    expect_bytes();
    buffer.release_to(buffer.begin() + buffer.size() * (i % 3) / 2);
  }
  buffer.release_to(buffer.end());
  EXPECT_EQ(pool.used(), 0U);
}

constexpr std::size_t kChunk = MessageMemory::kChunk;

// Sixteen places of four chunks each, and memory for eight chunks: four of them are kept.
struct MessageMemoryTest : testing::Test {
  static constexpr std::size_t kPlace = 4 * kChunk;
  std::vector<std::byte> space = std::vector<std::byte>(16 * kPlace);
  MessageMemory memory{space, kPlace, 8 * kChunk};

  MessageBuffer buffer(std::size_t chunks) {
    MessageBuffer made(memory);
    EXPECT_TRUE(made.grow(chunks * kChunk));
    return made;
  }
};

TEST_F(MessageMemoryTest, APlaceAloneTakesNothing) {
  std::vector<MessageBuffer> all;
  for (int i = 0; i < 16; ++i) ASSERT_TRUE(all.emplace_back(memory));
  EXPECT_EQ(memory.used_bytes(), 0U);
  EXPECT_FALSE(MessageBuffer(memory)) << "there are no more places";
  all.clear();
  EXPECT_TRUE(MessageBuffer(memory));
}

TEST_F(MessageMemoryTest, WhatIsThereStaysWhereItIs) {
  MessageBuffer one(memory);
  ASSERT_TRUE(one.grow(1));
  EXPECT_EQ(one.size(), kChunk);
  one.bytes()[0] = std::byte{7};
  const std::byte* before = one.bytes().data();
  MessageBuffer other(memory);
  ASSERT_TRUE(one.grow(kPlace));
  EXPECT_EQ(one.bytes().data(), before);
  EXPECT_EQ(one.bytes()[0], std::byte{7});
  EXPECT_GE(static_cast<std::size_t>(other.bytes().data() - before), kPlace);
  EXPECT_FALSE(other.grow(kPlace + 1)) << "larger than a place";
}

TEST_F(MessageMemoryTest, ThereIsNoMoreThanItsBound) {
  MessageBuffer one = buffer(2);
  MessageBuffer other = buffer(2);
  EXPECT_EQ(memory.used_bytes(), 4 * kChunk);
  EXPECT_EQ(memory.free_bytes(), 0U);
  EXPECT_FALSE(one.grow(2 * kChunk + 1));
  EXPECT_FALSE(MessageBuffer(memory).grow(1));
  other.reset();
  EXPECT_TRUE(one.grow(2 * kChunk + 1));
}

// One after the other completes, however many are half there.
TEST_F(MessageMemoryTest, OneOfThoseThatWaitCanAlwaysGoOn) {
  std::vector<MessageBuffer> half;
  half.reserve(4);
  for (int i = 0; i < 4; ++i) half.push_back(buffer(1));
  while (!half.empty()) {
    MessageBuffer& first = half.back();
    if (!first.grow(kPlace)) {
      ASSERT_TRUE(first.grow_as_kept(2 * kChunk));
      for (MessageBuffer& other : half)
        if (&other != &first) {
          EXPECT_FALSE(other.grow_as_kept(2 * kChunk));
        }
      ASSERT_TRUE(first.grow(kPlace));
      EXPECT_FALSE(first.grow(kPlace + 1));
    }
    EXPECT_LE(memory.used_bytes(), memory.bytes_max());
    half.pop_back();
  }
  EXPECT_EQ(memory.used_bytes(), 0U);
  EXPECT_EQ(memory.free_bytes(), 4 * kChunk);
}

TEST_F(MessageMemoryTest, WhatFreePlacesHaveTouchedGoesBack) {
  std::vector<MessageBuffer> all;
  all.reserve(16);
  for (int i = 0; i < 4; ++i) all.push_back(buffer(1));
  for (int i = 0; i < 8; ++i) all.emplace_back(memory);
  all.clear();  // the next ones take the other places first
  for (int i = 0; i < 8; ++i) all.emplace_back(memory);
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(all[static_cast<std::size_t>(i)].grow(1));
  EXPECT_TRUE(memory.surplus().empty()) << "eight chunks are the bound";
  MessageBuffer last(memory);
  ASSERT_TRUE(all[4].grow_as_kept(kPlace));
  const std::span<std::byte> first = memory.surplus();
  EXPECT_EQ(first.size(), kChunk);
  std::size_t given_back = first.size();
  for (auto more = memory.surplus(); !more.empty(); more = memory.surplus())
    given_back += more.size();
  EXPECT_GE(given_back, 3 * kChunk) << "there were twelve";
}

TEST(MessageMemory, ReportsWhetherItIsEnough) {
  std::vector<std::byte> space(16 * kChunk);
  EXPECT_TRUE(MessageMemory(space, kChunk, 2 * kChunk).is_enough());
  EXPECT_FALSE(MessageMemory(space, kChunk, 2 * kChunk - 1).is_enough());
  EXPECT_FALSE(MessageMemory(space, kChunk + 1, 4 * kChunk).is_enough());
  EXPECT_FALSE(MessageBuffer(*std::make_unique<MessageMemory>(std::span<std::byte>(), 100, 100)));
}

}  // namespace buffers_test
}  // namespace tims::link
