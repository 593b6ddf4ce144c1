// A sender and a receiver of one lane, with nothing between them but what a test does.
#include "router/link/lanes.h"

#include <cstring>
#include <memory>

#include <gtest/gtest.h>

#include "wire/header.h"

namespace tims::link {
namespace lanes_test {

using namespace std::chrono_literals;
constexpr std::uint64_t kAll = ~std::uint64_t{0};

struct LanesTest : testing::Test, ArrivalObserver, LossObserver {
  void on_message(Time, const RecordPrefix& prefix, core::Message& message) override {
    EXPECT_EQ(prefix.hops, 3);
    arrived.push_back(message.header.seq_nr);
    sizes.push_back(message.bytes.size());
    for (std::size_t i = kHeaderSize; i < message.bytes.size(); ++i)
      if (message.bytes[i] != std::byte{message.header.seq_nr}) ADD_FAILURE() << "altered";
  }
  void on_late(Time, const Header& header) override { late.push_back(header.seq_nr); }
  bool has_room_to_unpack() override { return unpacks; }
  void on_control(Time, const core::Message&) override {}
  void on_frame(Time, const KeepAlive&) override {}
  void on_frame(Time, const ChallengeFrame&) override {}
  void on_frame(Time, const ResponseFrame&) override {}
  void on_frame(Time, const CloseFrame&) override {}
  void on_frame(Time, const PauseFrame&) override {}
  void on_lost(Time, const Header& header, core::Outcome why) override {
    lost.push_back(header.seq_nr);
    last_loss = why;
  }

  void push(std::size_t size, std::uint64_t committed_max = kAll) {
    std::vector<std::byte> bytes(size, std::byte{seq});
    const Header header{.type = type, .seq_nr = seq++, .length = static_cast<std::uint32_t>(size)};
    wire::encode_header(header, std::span(bytes).first<kHeaderSize>());
    ASSERT_TRUE(sender.has_room(size));
    sender.push(now, {.hops = 3, .packed = packed}, bytes, committed_max);
  }
  LaneReceiver::Verdict deliver(Range range) {
    std::vector<std::byte> bytes(range.size());
    sender.read(range, bytes);
    const auto verdict = receiver.on_bytes(now, range.begin, bytes);
    done.clear();
    return verdict;
  }
  std::vector<Range> take_all(std::size_t size) {
    std::vector<Range> all;
    while (const auto range = sender.take(now, size, kAll)) all.push_back(*range);
    return all;
  }

  std::vector<std::byte> blocks = std::vector<std::byte>(8U << 20);
  static constexpr std::uint32_t kMessageMax = 9U << 20;
  static constexpr std::size_t kSpace = MessageMemory::kPlacesMin * kMessageMax;
  const std::unique_ptr<std::byte[]> messages = std::make_unique_for_overwrite<std::byte[]>(kSpace);
  core::BlockPool pool{aligned(blocks)};
  MessageMemory memory{{messages.get(), kSpace}, kMessageMax, 32U << 20};
  std::vector<MessageBuffer> done;
  Reassembly reassembly{pool, memory, done};
  LaneSender sender{pool, *this};
  LaneReceiver receiver{reassembly, *this, false};
  std::vector<std::uint8_t> arrived;
  std::vector<std::size_t> sizes;
  std::vector<std::uint8_t> lost;
  std::vector<std::uint8_t> late;  // at the receiver
  std::int8_t type = 0;
  bool packed = false;
  bool unpacks = true;
  core::Outcome last_loss{};
  std::uint8_t seq = 0;
  Time now{100s};

  static std::span<std::byte> aligned(std::vector<std::byte>& bytes) {
    void* at = bytes.data();
    std::size_t size = bytes.size();
    std::align(core::BlockPool::kBlockSize, core::BlockPool::kBlockSize, at, size);
    return {static_cast<std::byte*>(at), size};
  }
};

TEST_F(LanesTest, PiecesOfAnySizeBecomeMessages) {
  for (const std::size_t piece : {1U, 3U, 19U, 20U, 21U, 100U, 1000U}) {
    for (const std::size_t size : {16U, 17U, 64U, 5000U}) push(size);
    for (const Range range : take_all(piece)) {
      EXPECT_EQ(deliver(range), LaneReceiver::Verdict::kTaken);
      sender.on_acked(range);
    }
  }
  EXPECT_EQ(arrived.size(), 28U);
  EXPECT_TRUE(std::ranges::is_sorted(arrived));
  EXPECT_EQ(pool.used(), 0U);
  EXPECT_EQ(memory.used_bytes(), 0U);
}

// Commands of one type have a lifetime of 150 ms.
struct LifetimesTest : LanesTest {
  LifetimesTest() {
    EXPECT_TRUE(lifetimes.add("21 150ms"));
    sender.set_lifetimes(&lifetimes);
    reassembly.lifetimes = &lifetimes;
    type = 21;
  }
  using Seqs = std::vector<std::uint8_t>;
  policy::Lifetimes lifetimes;
};

TEST_F(LifetimesTest, ALostCommandIsRepeatedWithinItsLifetimeOnly) {
  for (const Duration pause : {150ms, 151ms}) {
    push(36);
    type = 22;
    push(36);
    type = 21;
    for (const Range range : take_all(40)) sender.on_lost(range);
    now += pause;
    for (const Range range : take_all(40)) {
      EXPECT_EQ(deliver(range), LaneReceiver::Verdict::kTaken);
      sender.on_acked(range);
    }
  }
  EXPECT_EQ(arrived, (Seqs{0, 1, 3})) << "others arrive however late";
  EXPECT_EQ(lost, Seqs{2});
  EXPECT_EQ(last_loss, core::Outcome::kExpired);
  EXPECT_EQ(pool.used(), 0U);
}

// On a line that is silent, what is repeated may be something else all the time.
TEST_F(LifetimesTest, TheLossOfACommandThatIsNotSentAgainIsReportedOnceAndInTime) {
  push(36);
  take_all(40);
  now += 150ms;
  sender.expire(now, 30s);
  EXPECT_TRUE(lost.empty());
  now += 1ms;
  sender.expire(now, 30s);
  EXPECT_EQ(lost, Seqs{0});
  now += 31s;
  sender.expire(now, 30s);
  EXPECT_EQ(lost, Seqs{0});
  push(36);
  now += 1s;
  sender.expire(now, 30s);
  sender.clear(now, core::Outcome::kNoRoute);
  EXPECT_EQ(lost, (Seqs{0, 1}));
}

TEST_F(LifetimesTest, ACommandThatWasNeverSentIsNotSentLate) {
  push(36);     // committed
  push(36, 0);  // waits
  now += 200ms;
  push(36, 0);  // in time
  for (const Range range : take_all(1000)) deliver(range);
  EXPECT_EQ(arrived, Seqs{2});
  EXPECT_EQ(lost, (Seqs{1, 0}));
}

TEST_F(LifetimesTest, WhatHasArrivedBehindAHoleIsNotDeliveredLate) {
  type = 22;
  push(36);
  type = 21;
  push(36);
  const auto all = take_all(40);
  deliver(all[1]);
  now += 100ms;
  push(36);
  const auto in_time = take_all(40);
  deliver(in_time[0]);
  now += 60ms;
  deliver(all[0]);
  EXPECT_EQ(arrived, (Seqs{0, 2}));
  EXPECT_EQ(late, Seqs{1});
  EXPECT_TRUE(lost.empty());
  now += 1s;
  push(36);
  deliver(take_all(40)[0]);
  EXPECT_EQ(arrived, (Seqs{0, 2, 3})) << "the hole is forgotten";
}

TEST_F(LifetimesTest, TheEndOfACommandThatCameLateDoesNotCompleteIt) {
  push(400);
  const auto all = take_all(100);
  deliver(all[0]);
  sender.on_acked(all[0]);
  for (std::size_t i = 1; i < all.size(); ++i) sender.on_lost(all[i]);
  now += 151ms;
  for (const Range range : take_all(100)) deliver(range);
  EXPECT_TRUE(arrived.empty());
  EXPECT_EQ(late, Seqs{0});
  push(36);
  deliver(take_all(100)[0]);
  EXPECT_EQ(arrived, Seqs{1});
}

TEST_F(LanesTest, BackwardsAndTwiceIsTheSame) {
  for (int i = 0; i < 10; ++i) push(1000);
  auto all = take_all(700);
  std::ranges::reverse(all);
  for (const Range range : all) deliver(range);
  for (const Range range : all) deliver(range);
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
  for (const Range range : all) sender.on_acked(range);
  EXPECT_EQ(sender.bytes(), 0U);
  EXPECT_EQ(pool.used(), 0U);
}

TEST_F(LanesTest, OnlyWhatIsMissingIsSentAgain) {
  push(3000);
  const auto all = take_all(1000);
  sender.on_acked(all[0]);
  sender.on_acked(all[2]);
  sender.on_lost({0, 3004});
  EXPECT_EQ(take_all(5000), (std::vector<Range>{{1000, 2000}, {3000, 3004}}));
}

TEST_F(LanesTest, TooOldIsSkipped) {
  push(2000);
  const auto first = take_all(1000);
  deliver(first[0]);
  now += 1s;
  push(100);
  sender.expire(now, 500ms);
  EXPECT_EQ(lost, (std::vector<std::uint8_t>{0}));
  EXPECT_EQ(last_loss, core::Outcome::kExpired);
  ASSERT_TRUE(sender.skip().has_value());
  EXPECT_EQ(*sender.skip(), 2004U);
  const auto rest = take_all(1000);
  EXPECT_EQ(deliver(rest[0]), LaneReceiver::Verdict::kTaken);
  EXPECT_TRUE(arrived.empty());
  receiver.on_skip(now, *sender.skip());
  done.clear();
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{1}));
  sender.on_skip_sent();
  EXPECT_FALSE(sender.skip().has_value());
  sender.on_skip_lost();
  EXPECT_TRUE(sender.skip().has_value());
  sender.on_skip_acked(2004);
  sender.on_skip_sent();
  sender.on_skip_lost();
  EXPECT_FALSE(sender.skip().has_value());
  EXPECT_EQ(memory.used_bytes(), 0U);
}

TEST_F(LanesTest, WaitingMessagesCanBeDropped) {
  push(500, 100);
  push(500, 100);
  push(600, 100);
  EXPECT_TRUE(sender.has_waiting());
  EXPECT_EQ(sender.drop_oldest().seq_nr, 1);
  for (const Range range : take_all(10'000)) deliver(range);
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{0, 2}));
}

TEST_F(LanesTest, WithoutMemoryNothingIsLost) {
  std::array<MessageBuffer, 4> all;
  for (MessageBuffer& one : all) {
    one = MessageBuffer(memory);
    (void)one.grow(kMessageMax);
  }
  while (all[3].grow(all[3].size() + 1)) {
  }
  ASSERT_TRUE(all[3].grow_as_kept(kMessageMax));
  while (all[2].grow(all[2].size() + 1)) {
  }
  push(20'000);
  const auto pieces = take_all(1000);
  std::vector<Range> refused;
  for (const Range range : pieces)
    if (deliver(range) == LaneReceiver::Verdict::kRefused) refused.push_back(range);
  EXPECT_FALSE(refused.empty());
  all = {};
  for (const Range range : refused) EXPECT_EQ(deliver(range), LaneReceiver::Verdict::kTaken);
  EXPECT_EQ(arrived.size(), 1U);
}

TEST_F(LanesTest, ACompressedMessageWaitsForRoomToUnpackIt) {
  for (const std::size_t size : {100U, 5000U}) {
    for (const bool backwards : {false, true}) {
      arrived.clear();
      packed = true;
      unpacks = false;
      push(size);
      packed = false;
      push(size);
      auto pieces = take_all(1000);
      if (backwards) std::ranges::reverse(pieces);
      for (int tries = 0; tries < 2; ++tries) {
        for (const Range range : pieces) (void)deliver(range);
        EXPECT_TRUE(arrived.empty()) << "nor does the next one overtake it";
      }
      unpacks = true;
      for (const Range range : pieces) {
        EXPECT_EQ(deliver(range), LaneReceiver::Verdict::kTaken);
        sender.on_acked(range);
      }
      EXPECT_EQ(arrived.size(), 2U);
      EXPECT_EQ(pool.used(), 0U);
    }
  }
}

TEST_F(LanesTest, NoBlockIsTakenForNothing) {
  push(20'000);
  const auto pieces = take_all(1000);
  std::vector<core::BlockPool::Index> taken;
  while (pool.available() > 0) taken.push_back(pool.allocate());
  EXPECT_EQ(deliver(pieces[10]), LaneReceiver::Verdict::kRefused);
  for (const auto index : taken) pool.release(index);
  for (const Range range : pieces) sender.on_acked(range);
  EXPECT_EQ(pool.used(), 0U);
}

TEST_F(LanesTest, TooFarAheadIsRefused) {
  std::vector<std::byte> bytes(100);
  EXPECT_EQ(receiver.on_bytes(now, kLaneWindow - 100, bytes), LaneReceiver::Verdict::kTaken);
  EXPECT_EQ(receiver.on_bytes(now, kLaneWindow - 99, bytes), LaneReceiver::Verdict::kRefused);
}

TEST_F(LanesTest, NobodySendsWhatTheOtherHasNoRoomFor) {
  std::vector<std::byte> large(24U << 20);
  core::BlockPool much(aligned(large));
  LaneSender own(much, *this);
  std::vector<std::byte> bytes(1U << 20);
  wire::encode_header({.length = 1U << 20}, std::span(bytes).first<kHeaderSize>());
  while (own.bytes() <= kLaneWindow) own.push(now, {}, bytes, kAll);
  EXPECT_TRUE(own.wants_to_send());
  std::uint64_t sent = 0;
  while (const auto range = own.take(now, 60'000, kAll)) sent = range->end;
  EXPECT_EQ(sent, kLaneWindow);
  EXPECT_FALSE(own.wants_to_send());
  own.on_acked({0, 2U << 20});
  EXPECT_TRUE(own.wants_to_send());
}

// The window moves on with what has arrived, although the message stays until it is whole.
TEST_F(LanesTest, AMessageMayBeLargerThanTheWindow) {
  std::vector<std::byte> large(24U << 20);
  core::BlockPool much(aligned(large));
  LaneSender own(much, *this);
  const std::size_t size = kLaneWindow + 100'000;
  std::vector<std::byte> bytes(size, std::byte{9});
  wire::encode_header({.seq_nr = 9, .length = static_cast<std::uint32_t>(size)},
                      std::span(bytes).first<kHeaderSize>());
  own.push(now, {.hops = 3}, bytes, kAll);
  while (const auto range = own.take(now, 60'000, kAll)) {
    std::vector<std::byte> piece(range->size());
    own.read(*range, piece);
    ASSERT_EQ(receiver.on_bytes(now, range->begin, piece), LaneReceiver::Verdict::kTaken);
    own.on_acked(*range);
  }
  EXPECT_EQ(sizes, (std::vector<std::size_t>{size}));
  EXPECT_EQ(own.bytes(), 0U);
}

TEST_F(LanesTest, WhatIsNoMessageBreaksTheLink) {
  std::vector<std::byte> bytes(100);
  EXPECT_EQ(receiver.on_bytes(now, 0, bytes), LaneReceiver::Verdict::kBroken);
}

// More gaps than are remembered: more is sent than necessary, and all arrives once.
TEST_F(LanesTest, ThousandsOfGaps) {
  for (int i = 0; i < 200; ++i) push(1000);
  const auto all = take_all(50);
  for (std::size_t i = 0; i < all.size(); i += 2)
    if (deliver(all[i]) == LaneReceiver::Verdict::kTaken) sender.on_acked(all[i]);
  for (int round = 0; round < 50 && arrived.size() < 200; ++round) {
    sender.on_lost({0, kAll});
    for (const Range range : take_all(1200))
      if (deliver(range) == LaneReceiver::Verdict::kTaken) sender.on_acked(range);
  }
  EXPECT_EQ(arrived.size(), 200U);
  EXPECT_EQ(pool.used(), 0U);
}

// --- what links take from each other

// A link whose lanes receive bytes from the test.
struct Peer : ArrivalObserver {
  Peer(core::BlockPool& pool, MessageMemory& memory, std::vector<MessageBuffer>& all_done)
      : done(all_done), reassembly{pool, memory, all_done, 4U << 20} {
    for (auto& lane : lanes) lane = std::make_unique<LaneReceiver>(reassembly, *this, false);
  }
  // The first bytes of a message of this length.
  LaneReceiver::Verdict begin(std::size_t lane, std::uint32_t length, std::size_t first) {
    std::vector<std::byte> bytes(kRecordPrefix + first);
    wire::encode_header({.seq_nr = 7, .length = length},
                        std::span(bytes).subspan<kRecordPrefix, kHeaderSize>());
    return more(lane, bytes);
  }
  LaneReceiver::Verdict more(std::size_t lane, std::span<std::byte> bytes) {
    // As it comes: in datagrams.
    while (!bytes.empty()) {
      const auto piece = bytes.first(std::min<std::size_t>(bytes.size(), 1200));
      const auto verdict = lanes[lane]->on_bytes(now, lanes[lane]->next(), piece);
      done.clear();
      if (verdict != LaneReceiver::Verdict::kTaken) return verdict;
      bytes = bytes.subspan(piece.size());
    }
    return LaneReceiver::Verdict::kTaken;
  }
  LaneReceiver::Verdict whole(std::size_t lane, std::uint32_t length) {
    return begin(lane, length, length);
  }
  void on_message(Time, const RecordPrefix&, core::Message&) override { ++arrived; }
  void on_control(Time, const core::Message&) override {}
  void on_frame(Time, const KeepAlive&) override {}
  void on_frame(Time, const ChallengeFrame&) override {}
  void on_frame(Time, const ResponseFrame&) override {}
  void on_frame(Time, const CloseFrame&) override {}
  void on_frame(Time, const PauseFrame&) override {}

  std::vector<MessageBuffer>& done;
  Reassembly reassembly;
  std::array<std::unique_ptr<LaneReceiver>, kLanes> lanes;
  int arrived = 0;
  Time now{100s};
};

struct SharesTest : LanesTest {
  static constexpr std::uint32_t kLarge = 1U << 20;
  using Verdict = LaneReceiver::Verdict;
  Peer first{pool, memory, done};
  Peer second{pool, memory, done};
  Peer honest{pool, memory, done};
};

// As much as they can, and not a byte for it.
TEST_F(SharesTest, WhatIsOnlyAnnouncedTakesNoMemory) {
  for (Peer* peer : {&first, &second})
    for (std::size_t lane = 0; lane < kLanes; ++lane)
      (void)peer->begin(lane, 4 * kLarge, kHeaderSize);
  EXPECT_LE(memory.used_bytes(), 2 * kLanes * MessageMemory::kChunk);
  EXPECT_EQ(honest.whole(0, 4 * kLarge), Verdict::kTaken);
  EXPECT_EQ(honest.arrived, 1);
}

// All that there is, by bytes that came; then others get their share of it.
TEST_F(SharesTest, APeerThatHoldsAllMemoryReturnsItWhenOthersNeedSome) {
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    (void)first.begin(lane, 4 * kLarge, 4 * kLarge - 10'000);
  EXPECT_EQ(memory.free_bytes(), 0U);
  EXPECT_EQ(honest.whole(0, kLarge), Verdict::kRefused);
  // The link keeps requesting memory, but may not keep all it holds.
  for (int i = 0; i < 3; ++i) {
    for (Peer* peer : {&first, &honest}) peer->now += LaneReceiver::kPatienceIfWanted / 2;
    std::vector<std::byte> rest(1000);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      (void)first.more(lane, rest);
      (void)first.lanes[lane]->give_up_stalled(first.now);
    }
    if (i == 0) {
      EXPECT_EQ(honest.whole(0, kLarge), Verdict::kRefused);
    }
  }
  EXPECT_EQ(honest.whole(0, 4 * kLarge), Verdict::kTaken);
  EXPECT_EQ(honest.arrived, 1);
}

// More than there is memory for, and each is half there.
TEST_F(SharesTest, OfMessagesThatWaitForEachOtherEachArrives) {
  constexpr std::uint32_t kSize = 4 * kLarge;
  std::vector<std::byte> stream(kRecordPrefix + kSize);
  wire::encode_header({.length = kSize}, std::span(stream).subspan<kRecordPrefix, kHeaderSize>());
  int refused = 0;
  for (int round = 0; round < 10'000 && first.arrived + second.arrived < 2 * int{kLanes}; ++round) {
    for (Peer* peer : {&first, &second})
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const std::size_t at = peer->lanes[lane]->next();
        std::vector<std::byte> copy(
            stream.begin() + static_cast<std::ptrdiff_t>(at),
            stream.begin() + static_cast<std::ptrdiff_t>(std::min(at + 6000, stream.size())));
        if (peer->more(lane, copy) != Verdict::kTaken) ++refused;
        ASSERT_LE(memory.used_bytes(), memory.bytes_max());
      }
  }
  EXPECT_GT(refused, 0);
  EXPECT_EQ(first.arrived, int{kLanes});
  EXPECT_EQ(second.arrived, int{kLanes});
  EXPECT_EQ(memory.used_bytes(), 0U);
}

// A message that waits for memory does not count as one without progress.
TEST_F(SharesTest, AMessageThatWaitsForMemoryIsNotGivenUp) {
  ASSERT_EQ(first.begin(0, 4 * kLarge, kLarge), Verdict::kTaken);
  for (std::size_t lane = 0; lane < kLanes; ++lane)
    (void)second.begin(lane, 4 * kLarge, 4 * kLarge - 1);
  ASSERT_EQ(memory.free_bytes(), 0U);
  std::vector<std::byte> more(100'000);
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(first.more(0, more), Verdict::kRefused);
    first.now += 1s;
    EXPECT_FALSE(first.lanes[0]->give_up_stalled(first.now).has_value());
  }
  first.now += LaneReceiver::kPatienceIfWanted;
  EXPECT_TRUE(first.lanes[0]->give_up_stalled(first.now).has_value()) << "it does not come again";
}

TEST_F(SharesTest, AStalledMessageIsGivenUpWhenOthersNeedItsMemory) {
  ASSERT_EQ(first.begin(3, kLarge, kLarge / 2), Verdict::kTaken);
  const auto give_up = [&] { return first.lanes[3]->give_up_stalled(first.now); };
  first.now += LaneReceiver::kPatience - 1ms;
  EXPECT_FALSE(give_up());
  memory.note_wanted(first.now, &first.reassembly);
  EXPECT_FALSE(give_up()) << "its own lanes wait for each other";
  memory.note_wanted(first.now, &second.reassembly);
  memory.note_wanted(first.now, &first.reassembly);
  const auto header = give_up();
  ASSERT_TRUE(header.has_value());
  EXPECT_EQ(header->length, kLarge);
  EXPECT_EQ(memory.used_bytes(), 0U);
  // What still comes of it is thrown away, and the next one arrives.
  std::vector<std::byte> rest(kLarge - kLarge / 2);
  EXPECT_EQ(first.more(3, rest), Verdict::kTaken);
  EXPECT_EQ(first.arrived, 0);
  EXPECT_EQ(first.whole(3, 5000), Verdict::kTaken);
  EXPECT_EQ(first.arrived, 1);
}

TEST_F(SharesTest, WhatMakesNoProgressIsGivenUpInTheEnd) {
  ASSERT_EQ(first.begin(3, kLarge, 5000), Verdict::kTaken);
  first.now += LaneReceiver::kPatience;
  EXPECT_TRUE(first.lanes[3]->give_up_stalled(first.now).has_value());
  EXPECT_FALSE(first.reassembly.is_used());
}

// Bytes far ahead of what is missing, in all lanes.
TEST_F(SharesTest, WhatComesTooEarlyIsNotKeptAtTheCostOfOthers) {
  std::vector<std::byte> piece(1000);
  for (std::size_t lane = 0; lane + 1 < kLanes; ++lane)
    for (std::uint64_t at = 4096; at < 4U << 20; at += 4096)
      (void)first.lanes[lane]->on_bytes(now, at, piece);
  EXPECT_LE(pool.used(), (pool.used() + pool.available()) / 2 + 1);
  EXPECT_EQ(second.lanes[0]->on_bytes(now, 4096, piece), Verdict::kTaken);
}

}  // namespace lanes_test
}  // namespace tims::link
