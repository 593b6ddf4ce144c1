#include "router/link/message_memory.h"

#include <vector>

#include <gtest/gtest.h>

namespace tims::link {
namespace {

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

TEST(MessageMemory, SaysWhetherItIsEnough) {
  std::vector<std::byte> space(16 * kChunk);
  EXPECT_TRUE(MessageMemory(space, kChunk, 2 * kChunk).is_enough());
  EXPECT_FALSE(MessageMemory(space, kChunk, 2 * kChunk - 1).is_enough());
  EXPECT_FALSE(MessageMemory(space, kChunk + 1, 4 * kChunk).is_enough());
  EXPECT_FALSE(MessageBuffer(*std::make_unique<MessageMemory>(std::span<std::byte>(), 100, 100)));
}

}  // namespace
}  // namespace tims::link
