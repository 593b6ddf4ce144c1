#include "router/link/message_memory.h"

#include <vector>

#include <gtest/gtest.h>

namespace tims::link {
namespace {

constexpr std::size_t kPiece = MessageMemory::kPieceMin;

TEST(MessageMemory, WhatIsGivenBackBecomesWholeAgain) {
  std::vector<std::byte> bytes(16 * kPiece);
  MessageMemory memory(bytes);
  {
    std::vector<MessageBuffer> all;
    for (int i = 0; i < 16; ++i) ASSERT_TRUE(all.emplace_back(memory, 1));
    EXPECT_FALSE(MessageBuffer(memory, 1));
    EXPECT_EQ(memory.used_bytes(), 16 * kPiece);
  }
  EXPECT_EQ(memory.used_bytes(), 0U);
  EXPECT_TRUE(MessageBuffer(memory, 16 * kPiece));
  EXPECT_FALSE(MessageBuffer(memory, 16 * kPiece + 1));
}

TEST(MessageMemory, PiecesDoNotOverlap) {
  std::vector<std::byte> bytes(64 * kPiece);
  MessageMemory memory(bytes);
  std::vector<MessageBuffer> all;
  std::uint64_t state = 7;
  for (int i = 0; i < 5000; ++i) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    const auto what = state >> 40;
    if (what % 2 == 0 && !all.empty()) {
      std::swap(all[what % all.size()], all.back());
      all.pop_back();
      continue;
    }
    MessageBuffer buffer(memory, what % (8 * kPiece));
    if (!buffer) continue;
    for (const MessageBuffer& other : all) {
      const bool apart = buffer.bytes().data() >= other.bytes().data() + other.bytes().size() ||
                         other.bytes().data() >= buffer.bytes().data() + buffer.bytes().size();
      ASSERT_TRUE(apart) << "step " << i;
    }
    all.push_back(std::move(buffer));
  }
  all.clear();
  EXPECT_EQ(memory.used_bytes(), 0U);
  EXPECT_TRUE(MessageBuffer(memory, 64 * kPiece));
}

TEST(MessageMemory, UsesAPowerOfTwoOfWhatItGets) {
  std::vector<std::byte> bytes(7 * kPiece);
  MessageMemory memory(bytes);
  EXPECT_FALSE(MessageBuffer(memory, 5 * kPiece));
  EXPECT_TRUE(MessageBuffer(memory, 4 * kPiece));
  MessageMemory nothing(std::span<std::byte>(bytes).first(100));
  EXPECT_FALSE(MessageBuffer(nothing, 1));
}

}  // namespace
}  // namespace tims::link
