#include "router/link/stream_buffer.h"

#include <deque>
#include <vector>

#include <gtest/gtest.h>

namespace tims::link {
namespace {

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
  void expect_bytes() {
    std::vector<std::byte> bytes(buffer.size());
    buffer.read(buffer.begin(), bytes);
    for (std::size_t i = 0; i < bytes.size(); ++i)
      ASSERT_EQ(bytes[i], static_cast<std::byte>(buffer.begin() + i));
  }
  std::uint64_t next = 0;
};

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

}  // namespace
}  // namespace tims::link
