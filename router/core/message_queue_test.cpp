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

// --- the newest sample only

Bytes sample(std::uint32_t length, std::uint8_t priority, std::uint32_t src, int mark = 0,
             std::uint8_t flags = flag::kNativeOrder | flag::kStream) {
  Bytes bytes(length, static_cast<std::byte>(mark));
  wire::encode_header(
      {.flags = flags, .type = -6, .priority = priority, .src = Address(src), .length = length},
      std::span(bytes).first<kHeaderSize>());
  return bytes;
}

class KeepNewestTest : public MessageQueueTest {
 protected:
  KeepNewestTest() { queue_.keep_newest(streams_); }
  bool push(const Bytes& bytes) {
    streams_.add(wire::decode_header(std::span(bytes).first<kHeaderSize>()));
    return MessageQueueTest::push(bytes);
  }
  StreamCounters::Stream counted(std::uint32_t src) const {
    StreamCounters::Stream found;
    streams_.for_each([&](const StreamCounters::Stream& stream) {
      if (stream.src == Address(src)) found = stream;
    });
    return found;
  }
  StreamCounters streams_;
};

TEST_F(KeepNewestTest, ANewerSampleTakesTheTurnOfTheOlder) {
  push(sample(100, 5, 1, 1));
  push(sample(100, 5, 2, 2));
  EXPECT_TRUE(push(sample(130, 5, 1, 3)));
  EXPECT_EQ(waiting(), sample(130, 5, 1, 3) + sample(100, 5, 2, 2));
  EXPECT_EQ(queue_.bytes(), 230U);
  EXPECT_EQ(replaced_[kConventionalClasses.of(std::uint8_t{5})], (Count{1, 100}));
  EXPECT_EQ(counted(1).samples, 2U);
  EXPECT_EQ(counted(1).dropped, 1U);
  EXPECT_EQ(counted(1).waiting, 1U);
  EXPECT_EQ(counted(2).dropped, 0U);
}

TEST_F(KeepNewestTest, OtherMessagesAreAllKept) {
  push(sample(100, 5, 1, 1, flag::kNativeOrder));
  push(sample(100, 5, 1, 2, flag::kNativeOrder));
  push(sample(100, 5, 1, 3));
  push(sample(100, 6, 1, 4));
  EXPECT_EQ(waiting(), sample(100, 6, 1, 4) + sample(100, 5, 1, 1, flag::kNativeOrder) +
                           sample(100, 5, 1, 2, flag::kNativeOrder) + sample(100, 5, 1, 3));
  EXPECT_EQ(replaced_, LossCounts{});
}

TEST_F(KeepNewestTest, ASampleThatIsPartlyWrittenStays) {
  push(sample(100, 5, 1, 1));
  queue_.consume(50);
  push(sample(100, 5, 1, 2));
  push(sample(100, 5, 1, 3));
  const Bytes begun = sample(100, 5, 1, 1);
  EXPECT_EQ(waiting(), Bytes(begun.begin() + 50, begun.end()) + sample(100, 5, 1, 3));
  queue_.consume(150);
  EXPECT_TRUE(queue_.empty());
  EXPECT_EQ(counted(1).dropped, 1U);
  EXPECT_EQ(counted(1).waiting, 0U);
  EXPECT_EQ(pool_.used(), 0U);
}

TEST_F(KeepNewestTest, WithoutRoomForTheDifferenceTheOldestMakesRoom) {
  push(sample(500, 5, 1, 1));
  push(sample(400, 5, 2, 2));
  EXPECT_TRUE(push(sample(700, 5, 2, 3)));
  EXPECT_EQ(waiting(), sample(700, 5, 2, 3));
  EXPECT_EQ(counted(1).dropped, 1U);
  EXPECT_EQ(counted(2).dropped, 1U);
  EXPECT_FALSE(push(sample(1001, 5, 2, 4))) << "never fits";
  EXPECT_EQ(counted(2).dropped, 2U);
}

TEST_F(KeepNewestTest, HoldsAtMostOneSampleOfAStreamInItsTurn) {
  std::mt19937 random(3);
  std::vector<std::pair<std::uint32_t, Bytes>> model;  // in order
  queue_.set_bytes_max(200'000);
  for (int step = 0; step < 20'000; ++step) {
    const std::uint32_t src = 1 + static_cast<std::uint32_t>(random() % 20);
    const Bytes bytes =
        sample(16 + static_cast<std::uint32_t>(random() % 6000), 5, src, step % 256);
    ASSERT_TRUE(push(bytes));
    const auto older = std::ranges::find(model, src, &std::pair<std::uint32_t, Bytes>::first);
    if (older == model.end())
      model.emplace_back(src, bytes);
    else
      older->second = bytes;
    if (random() % 2 == 0) {
      queue_.consume(model.front().second.size());
      model.erase(model.begin());
    }
    Bytes expected;
    for (const auto& item : model) expected = std::move(expected) + item.second;
    ASSERT_EQ(waiting(), expected) << "step " << step;
  }
}

}  // namespace message_queue_test
}  // namespace tims::core
