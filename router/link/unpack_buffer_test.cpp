#include "router/link/unpack_buffer.h"

#include <cstring>

#include <gtest/gtest.h>

namespace tims::link {
namespace unpack_buffer_test {

constexpr std::uint32_t kLargest = 64 << 10;
constexpr std::size_t kPlaces = 16;

struct UnpackBufferTest : testing::Test {
  // Room for eight of the largest messages; one of them is the reserve.
  std::vector<std::byte> pages = std::vector<std::byte>(kPlaces * kLargest);
  MessageMemory memory{pages, kLargest, std::size_t{8} * kLargest};
  std::vector<MessageBuffer> done;
  UnpackBuffer buffer{memory, done};

  std::size_t taken_until_full(std::size_t size) {
    std::size_t count = 0;
    while (!buffer.take(size).empty()) ++count;
    return count;
  }
};

TEST_F(UnpackBufferTest, ManySmallMessagesShareAPlace) {
  const std::size_t small = 1024;
  for (std::size_t i = 0; i < 2 * kPlaces; ++i) {
    const auto bytes = buffer.take(small);
    ASSERT_EQ(bytes.size(), small);
    std::memset(bytes.data(), static_cast<int>(i), bytes.size());
  }
  EXPECT_EQ(memory.free_places(), kPlaces - 1);
}

TEST_F(UnpackBufferTest, MessagesDoNotOverlap) {
  const std::size_t sizes[] = {17, 1000, kLargest, 1, kLargest - 8, 64, 5000};
  std::vector<std::span<std::byte>> all;
  for (std::size_t i = 0; i < std::size(sizes); ++i) {
    all.push_back(buffer.take(sizes[i]));
    ASSERT_EQ(all.back().size(), sizes[i]);
    std::memset(all.back().data(), static_cast<int>(i + 1), sizes[i]);
  }
  for (std::size_t i = 0; i < all.size(); ++i)
    for (const std::byte byte : all[i]) ASSERT_EQ(byte, static_cast<std::byte>(i + 1));
}

TEST_F(UnpackBufferTest, WithoutMemoryNothingIsTakenAndWhatWasTakenStays) {
  EXPECT_EQ(taken_until_full(kLargest), 7U);
  EXPECT_FALSE(buffer.reserve(1));
  EXPECT_EQ(done.size(), 6U);
  done.clear();
  buffer.release();
  EXPECT_EQ(memory.used_bytes(), 0U);
  EXPECT_EQ(taken_until_full(kLargest), 7U) << "all of it is there again";
}

TEST_F(UnpackBufferTest, WhatIsReservedCanBeTaken) {
  for (int i = 0; i < 6; ++i) ASSERT_FALSE(buffer.take(kLargest).empty());
  ASSERT_TRUE(buffer.reserve(kLargest));
  MessageBuffer other(memory);
  EXPECT_FALSE(other.grow(1));
  EXPECT_FALSE(buffer.take(kLargest).empty());
}

}  // namespace unpack_buffer_test
}  // namespace tims::link
