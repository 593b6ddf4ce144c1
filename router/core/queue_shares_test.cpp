// Queues of many readers that share the memory of a pool: some have stopped reading.
#include "router/core/queue_shares.h"

#include <algorithm>
#include <deque>
#include <vector>

#include <gtest/gtest.h>

#include "router/core/message_queue.h"
#include "wire/header.h"

namespace tims::core {
namespace queue_shares_test {

using Bytes = std::vector<std::byte>;

Bytes message(std::uint32_t length, std::uint8_t priority) {
  Bytes bytes(length);
  wire::encode_header({.priority = priority, .length = length},
                      std::span(bytes).first<kHeaderSize>());
  return bytes;
}

// Counts what it lost, and gives up when it is asked.
struct Reader final : QueueOwner {
  Reader(QueueShares& shares, std::uint64_t bytes_max) : queue(shares, *this, bytes_max) {}
  void on_dropped(const LossCounts& lost) override {
    for (const Count& count : lost) dropped.add(count);
  }
  void give_up() override {
    LossCounts lost{};
    queue.clear(lost);
    gave_up = true;
  }
  bool push(std::size_t size, std::uint8_t priority = 0) {
    LossCounts replaced{};
    return queue.push(message(static_cast<std::uint32_t>(size), priority), priority, replaced);
  }
  // As an output does whose socket takes only the header of a message.
  bool begin(std::size_t size) {
    if (!queue.reserve(size)) return false;
    const Bytes bytes = message(static_cast<std::uint32_t>(size), 0);
    return queue.push_rest(std::span(bytes).subspan(kHeaderSize), {.length = 16});
  }

  MessageQueue queue;
  Count dropped;
  bool gave_up = false;
};

class QueueSharesTest : public testing::Test {
 protected:
  static constexpr std::size_t kBlocks = 1024;
  static constexpr std::size_t kPoolBytes = kBlocks * BlockPool::kBlockSize;

  // Queues of 20 clients that have stopped reading long ago.
  void stall(std::uint64_t bytes_max = 1 << 20) {
    for (int i = 0; i < 20; ++i) readers_.emplace_back(shares_, bytes_max);
    for (int n = 0; n < 2000; ++n)
      for (Reader& reader : readers_) reader.push(1000);
    shares_.set_now(shares_.now() + QueueShares::kPatience);
  }
  Count dropped() const {
    Count sum;
    for (const Reader& reader : readers_) sum.add(reader.dropped);
    return sum;
  }
  int given_up() const {
    return static_cast<int>(std::ranges::count(readers_, true, &Reader::gave_up));
  }

  std::vector<std::byte> memory_ = std::vector<std::byte>(kPoolBytes);
  BlockPool pool_{memory_};
  QueueShares shares_{pool_};
  std::deque<Reader> readers_;
};

TEST_F(QueueSharesTest, StalledReceiversLeaveRoomForTheNext) {
  stall();
  EXPECT_GT(pool_.available(), 60U);
  for (const Reader& reader : readers_) EXPECT_GT(reader.queue.bytes(), 0U) << "each has some";
}

TEST_F(QueueSharesTest, WithoutSharesOneTakesAllOfThePool) {
  MessageQueue queue(pool_, kPoolBytes);
  LossCounts replaced{};
  while (queue.push(message(1000, 0), 0, replaced) &&
         replaced[0].messages + replaced[1].messages + replaced[2].messages == 0) {
    if (pool_.available() < 4) break;
  }
  EXPECT_LT(pool_.available(), 4U);
}

TEST_F(QueueSharesTest, AloneItHasAThirdOfThePoolAndItsBoundAtMost) {
  Reader reader(shares_, kPoolBytes);
  Reader bounded(shares_, 5000);
  for (int n = 0; n < 5000; ++n) {
    EXPECT_TRUE(reader.push(1000));
    EXPECT_TRUE(bounded.push(1000));
  }
  EXPECT_GT(reader.queue.bytes(), kPoolBytes * 3 / 10);
  EXPECT_LE(reader.queue.bytes(), kPoolBytes * 34 / 100);
  EXPECT_EQ(bounded.queue.bytes(), 5000U);
  // More than there is for it, whatever its priority.
  EXPECT_FALSE(reader.push(kPoolBytes * 6 / 10, 255));
}

// Three quarters of the pool for one message of a client that reads.
TEST_F(QueueSharesTest, ABegunMessageGetsTheRoomOfStalledReaders) {
  stall();
  Reader reader(shares_, kPoolBytes);
  const std::size_t size = kPoolBytes * 3 / 4;
  ASSERT_LT(pool_.available() * BlockPool::kBlockSize, size);
  EXPECT_TRUE(reader.begin(size));
  EXPECT_EQ(reader.queue.bytes(), size - kHeaderSize);
  EXPECT_GT(dropped().bytes, 0U);
  EXPECT_EQ(given_up(), 0) << "their connections stay";
  // The others get no more of it than they have.
  for (Reader& stalled : readers_) stalled.push(1000, 255);
  EXPECT_EQ(reader.dropped.messages, 0U);
  EXPECT_EQ(reader.queue.bytes(), size - kHeaderSize);
}

TEST_F(QueueSharesTest, AWaitingMessageGetsTheRoomOfStalledReaders) {
  stall();
  Reader reader(shares_, kPoolBytes);
  EXPECT_TRUE(reader.push(kPoolBytes / 4));
  EXPECT_GT(dropped().bytes, 0U);
}

TEST_F(QueueSharesTest, AStalledReaderTakesNothingFromOthers) {
  stall();
  for (Reader& reader : readers_) reader.push(200'000);
  EXPECT_EQ(dropped().bytes, 0U);
}

TEST_F(QueueSharesTest, OneThatReadsKeepsItsShareAndGivesTheRest) {
  Reader much(shares_, kPoolBytes);
  while (much.queue.bytes() < kPoolBytes / 4) ASSERT_TRUE(much.push(1000));
  Reader more(shares_, kPoolBytes);
  EXPECT_TRUE(more.begin(kPoolBytes * 45 / 100));
  EXPECT_EQ(much.dropped.bytes, 0U) << "there is enough";
  Reader third(shares_, kPoolBytes);
  EXPECT_FALSE(third.begin(kPoolBytes * 6 / 10));
  EXPECT_EQ(much.dropped.bytes, 0U) << "nothing is dropped in vain";
  // With eleven others a share is a twelfth.
  for (int i = 0; i < 9; ++i) ASSERT_TRUE(readers_.emplace_back(shares_, kPoolBytes).push(1000));
  EXPECT_TRUE(third.begin(kPoolBytes * 35 / 100));
  EXPECT_GT(much.dropped.bytes, 0U);
  EXPECT_GE(much.queue.bytes(), kPoolBytes / 12);
  EXPECT_EQ(dropped().bytes, 0U) << "they have less than a share";
  EXPECT_FALSE(much.gave_up || more.gave_up);
}

// All of the pool is begun messages.
TEST_F(QueueSharesTest, OneThatStoppedFirstIsDisconnected) {
  const std::size_t size = kPoolBytes / 5;
  for (int i = 0; i < 4; ++i) {
    shares_.set_now(shares_.now() + std::chrono::milliseconds(1));
    readers_.emplace_back(shares_, kPoolBytes);
    ASSERT_TRUE(readers_.back().begin(size));
  }
  Reader reader(shares_, kPoolBytes);
  EXPECT_FALSE(reader.begin(2 * size)) << "the others have just begun";
  EXPECT_EQ(given_up(), 0);
  shares_.set_now(shares_.now() + QueueShares::kPatience);
  readers_[0].queue.consume(1);  // it reads
  EXPECT_TRUE(reader.begin(2 * size));
  EXPECT_FALSE(readers_[0].gave_up);
  EXPECT_TRUE(readers_[1].gave_up);
  EXPECT_FALSE(readers_[3].gave_up) << "no more than necessary";
}

}  // namespace queue_shares_test
}  // namespace tims::core
