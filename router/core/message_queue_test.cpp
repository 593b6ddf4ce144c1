#include "router/core/message_queue.h"

#include <algorithm>
#include <deque>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "wire/header.h"

namespace tims::core {
namespace message_queue_test {

using Bytes = std::vector<std::byte>;

// `mark` makes it different from others of the same size.
Bytes message(std::uint32_t length, std::uint8_t priority, std::uint32_t mark = 0) {
  Bytes bytes(length);
  for (std::size_t i = kHeaderSize; i < length; ++i) {
    bytes[i] = static_cast<std::byte>((mark + i) % 251);
  }
  wire::encode_header({.priority = priority, .src = Address(mark), .length = length},
                      std::span(bytes).first<kHeaderSize>());
  return bytes;
}

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class MessageQueueTest : public testing::Test {
 protected:
  bool push(const Bytes& bytes) {
    return queue_.push(bytes, wire::decode_header(std::span(bytes).first<kHeaderSize>()).priority,
                       replaced_);
  }
  Bytes waiting() {
    std::vector<std::span<const std::byte>> pieces(4096);
    pieces.resize(queue_.gather(pieces));
    Bytes bytes;
    for (const auto& piece : pieces) bytes.insert(bytes.end(), piece.begin(), piece.end());
    return bytes;
  }

  std::vector<std::byte> memory_ = std::vector<std::byte>(64 * BlockPool::kBlockSize);
  BlockPool pool_{memory_};
  MessageQueue queue_{pool_, 1000};
  LossCounts replaced_{};
};

// A text with priority 50 still yields to other messages; it is counted as a text.
TEST_F(MessageQueueTest, TextsAreCountedAsTexts) {
  Bytes text = message(100, 50);
  wire::encode_header({.priority = 50, .dest = text_sink(), .length = 100},
                      std::span(text).first<kHeaderSize>());
  const auto put = [&] {
    return queue_.push(text, PriorityClasses().waits_with({.priority = 50, .dest = text_sink()}),
                       replaced_);
  };
  while (replaced_[0].messages == 0) ASSERT_TRUE(put());
  EXPECT_TRUE(push(message(900, 1)));
  EXPECT_EQ(replaced_[0].messages, 10U);
  EXPECT_EQ(replaced_[6].messages, 0U);
  EXPECT_TRUE(put());
  LossCounts lost{};
  queue_.consume(950);  // half of the text
  queue_.clear(lost);
  EXPECT_EQ(lost[0].messages, 1U);
}

TEST_F(MessageQueueTest, TakesNoMemoryWhileItIsEmpty) {
  EXPECT_EQ(pool_.used(), 0U);
  push(message(20, 1));
  EXPECT_GT(pool_.used(), 0U);
  queue_.consume(20);
  EXPECT_TRUE(queue_.empty());
  EXPECT_EQ(pool_.used(), 0U);
}

TEST_F(MessageQueueTest, TheOldestOfTheLowestPriorityMakesRoom) {
  push(message(400, 5, 1));
  push(message(400, 5, 2));
  push(message(200, 9, 3));
  EXPECT_TRUE(push(message(300, 5, 4)));
  EXPECT_EQ(waiting(), message(200, 9, 3) + message(400, 5, 2) + message(300, 5, 4));
  EXPECT_EQ(replaced_[kConventionalClasses.of(std::uint8_t{5})], (Count{1, 400}));
}

TEST_F(MessageQueueTest, SeveralMakeRoomForALargeOne) {
  for (std::uint32_t i = 0; i < 10; ++i) push(message(100, static_cast<std::uint8_t>(i * 10), i));
  EXPECT_TRUE(push(message(250, 100, 77)));
  EXPECT_EQ(queue_.bytes(), 950U);
  for (const std::uint8_t gone : {std::uint8_t{0}, std::uint8_t{10}, std::uint8_t{20}})
    EXPECT_EQ(replaced_[kConventionalClasses.of(gone)], (Count{1, 100}));
}

TEST_F(MessageQueueTest, OneThatNeverFitsIsRefused) {
  EXPECT_FALSE(push(message(1001, 255)));
  EXPECT_TRUE(queue_.empty());
  EXPECT_EQ(pool_.used(), 0U);
  EXPECT_TRUE(push(message(1000, 0)));
}

TEST_F(MessageQueueTest, OneThatIsPartlyWrittenIsNeitherOvertakenNorReplaced) {
  push(message(600, 1, 1));
  queue_.consume(10);
  push(message(300, 200, 2));
  const Bytes begun = message(600, 1, 1);
  EXPECT_EQ(waiting(), Bytes(begun.begin() + 10, begun.end()) + message(300, 200, 2));
  // The 590 bytes that remain stay whatever comes.
  EXPECT_TRUE(push(message(400, 255, 3)));
  EXPECT_FALSE(push(message(500, 255, 4)));
  EXPECT_EQ(waiting(), Bytes(begun.begin() + 10, begun.end()) + message(400, 255, 3));
  queue_.consume(590);
  EXPECT_EQ(waiting(), message(400, 255, 3));
}

TEST_F(MessageQueueTest, TheRestOfAMessageComesFirst) {
  const Bytes whole = message(500, 3, 1);
  EXPECT_TRUE(queue_.push_rest(std::span(whole).subspan(123), {.priority = 3}));
  push(message(100, 255, 2));
  EXPECT_EQ(waiting(), Bytes(whole.begin() + 123, whole.end()) + message(100, 255, 2));
  queue_.consume(377 + 100);
  EXPECT_TRUE(queue_.empty());
  EXPECT_EQ(pool_.used(), 0U);
}

TEST_F(MessageQueueTest, RefusesWhenThePoolIsExhausted) {
  std::vector<BlockPool::Index> others;
  while (pool_.available() > 2) others.push_back(pool_.allocate());
  EXPECT_FALSE(push(message(100, 1)));  // the index and the spare block leave nothing
  const Bytes whole = message(900, 3);
  EXPECT_TRUE(queue_.push_rest(std::span(whole).subspan(1), {.priority = 3}));
  EXPECT_FALSE(push(message(100, 1)));
  queue_.consume(899);
  pool_.release(others.back());
  EXPECT_TRUE(push(message(100, 1)));
  EXPECT_FALSE(push(message(100, 0)));
  EXPECT_TRUE(push(message(100, 2)));  // the other one makes room
  EXPECT_EQ(replaced_[kConventionalClasses.of(std::uint8_t{1})], (Count{1, 100}));
}

TEST_F(MessageQueueTest, CountsWhatIsThrownAway) {
  push(message(100, 1));
  push(message(200, 40));
  push(message(200, 40));
  queue_.consume(50);
  LossCounts lost{};
  queue_.clear(lost);
  EXPECT_EQ(lost[kConventionalClasses.of(std::uint8_t{1})], (Count{1, 100}));
  EXPECT_EQ(lost[kConventionalClasses.of(std::uint8_t{40})], (Count{2, 350}));
  EXPECT_TRUE(queue_.empty());
  EXPECT_EQ(pool_.used(), 0U);
}

// A simple reference implementation of the rules in the header.
class Model {
 public:
  explicit Model(std::size_t bytes_max) : bytes_max_(bytes_max) {}

  bool push(const Bytes& bytes, std::uint8_t priority, LossCounts& replaced) {
    std::vector<Item> kept = items_;
    LossCounts losses{};
    while (size(kept) + begun_.size() + bytes.size() > bytes_max_) {
      const auto victim = std::ranges::min_element(kept, {}, &Item::priority);
      if (victim == kept.end() || victim->priority > priority) return false;
      losses[kConventionalClasses.of(victim->priority)].add(victim->bytes.size());
      kept.erase(victim);
    }
    items_ = kept;
    items_.push_back({priority, bytes});
    for (std::size_t i = 0; i < kClasses; ++i) {
      replaced[i].messages += losses[i].messages;
      replaced[i].bytes += losses[i].bytes;
    }
    return true;
  }

  void consume(std::size_t n) {
    const std::size_t of_begun = std::min(n, begun_.size());
    begun_.erase(begun_.begin(), begun_.begin() + static_cast<std::ptrdiff_t>(of_begun));
    n -= of_begun;
    while (n > 0) {
      const auto first = std::ranges::max_element(items_, {}, &Item::priority);
      const std::size_t taken = std::min(n, first->bytes.size());
      begun_.assign(first->bytes.begin() + static_cast<std::ptrdiff_t>(taken), first->bytes.end());
      items_.erase(first);
      n -= taken;
    }
  }

  [[nodiscard]] Bytes waiting() const {
    std::vector<Item> sorted = items_;
    std::ranges::stable_sort(sorted, std::greater<>{}, &Item::priority);
    Bytes bytes = begun_;
    for (const Item& item : sorted) bytes = std::move(bytes) + item.bytes;
    return bytes;
  }

 private:
  struct Item {
    std::uint8_t priority;
    Bytes bytes;
  };
  static std::size_t size(const std::vector<Item>& items) {
    std::size_t sum = 0;
    for (const Item& item : items) sum += item.bytes.size();
    return sum;
  }

  std::size_t bytes_max_;
  std::vector<Item> items_;
  Bytes begun_;
};

TEST(MessageQueueModel, BehavesAsItsRulesSay) {
  for (std::uint32_t seed = 1; seed <= 30; ++seed) {
    std::mt19937 generator(seed);
    const auto random = [&] { return static_cast<std::uint32_t>(generator()); };
    std::vector<std::byte> memory(300 * BlockPool::kBlockSize);
    BlockPool pool(memory);
    const std::size_t bytes_max = 1000 + random() % 40'000;
    const std::uint32_t longest = 17 + random() % 12'000;
    const std::uint32_t priorities = 1 + random() % 256;
    MessageQueue queue(pool, bytes_max);
    Model model(bytes_max);
    LossCounts replaced{};
    LossCounts expected{};
    std::vector<std::span<const std::byte>> pieces(4096);
    for (std::uint32_t step = 0; step < 1500; ++step) {
      const auto priority = static_cast<std::uint8_t>(random() % priorities);
      const Bytes bytes = message(16 + random() % (longest - 16), priority, step);
      ASSERT_EQ(queue.push(bytes, priority, replaced), model.push(bytes, priority, expected))
          << "seed " << seed << " step " << step;
      if (random() % 3 == 0) {
        const std::size_t n = random() % (queue.bytes() + 1);
        queue.consume(n);
        model.consume(n);
      }
      const auto shown = std::span(pieces).first(queue.gather(pieces));
      Bytes waiting;
      for (const auto& piece : shown) waiting.insert(waiting.end(), piece.begin(), piece.end());
      ASSERT_EQ(waiting, model.waiting()) << "seed " << seed << " step " << step;
      ASSERT_EQ(queue.bytes(), waiting.size());
    }
    EXPECT_EQ(replaced, expected);
    queue.consume(queue.bytes());
    EXPECT_EQ(pool.used(), 0U);
  }
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

class MessageQueueShareTest : public testing::Test {
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

TEST_F(MessageQueueShareTest, StalledReceiversLeaveRoomForTheNext) {
  stall();
  EXPECT_GT(pool_.available(), 60U);
  for (const Reader& reader : readers_) EXPECT_GT(reader.queue.bytes(), 0U) << "each has some";
}

TEST_F(MessageQueueShareTest, WithoutSharesOneTakesAllOfThePool) {
  MessageQueue queue(pool_, kPoolBytes);
  LossCounts replaced{};
  while (queue.push(message(1000, 0), 0, replaced) &&
         replaced[0].messages + replaced[1].messages + replaced[2].messages == 0) {
    if (pool_.available() < 4) break;
  }
  EXPECT_LT(pool_.available(), 4U);
}

TEST_F(MessageQueueShareTest, AloneItHasAThirdOfThePoolAndItsBoundAtMost) {
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
TEST_F(MessageQueueShareTest, ABegunMessageGetsTheRoomOfStalledReaders) {
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

TEST_F(MessageQueueShareTest, AWaitingMessageGetsTheRoomOfStalledReaders) {
  stall();
  Reader reader(shares_, kPoolBytes);
  EXPECT_TRUE(reader.push(kPoolBytes / 4));
  EXPECT_GT(dropped().bytes, 0U);
}

TEST_F(MessageQueueShareTest, AStalledReaderTakesNothingFromOthers) {
  stall();
  for (Reader& reader : readers_) reader.push(200'000);
  EXPECT_EQ(dropped().bytes, 0U);
}

TEST_F(MessageQueueShareTest, OneThatReadsKeepsItsShareAndGivesTheRest) {
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
TEST_F(MessageQueueShareTest, OneThatStoppedFirstIsDisconnected) {
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

}  // namespace message_queue_test
}  // namespace tims::core
