// Samples of streams, out and in.
#include "router/link/samples.h"

#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "wire/header.h"

namespace tims::link {
namespace samples_test {

using namespace std::chrono_literals;

struct SamplesTest : testing::Test, ArrivalObserver, LossObserver {
  void on_message(Time, const RecordPrefix&, core::Message& message) override {
    arrived.push_back(message.header.seq_nr);
  }
  void on_control(Time, const core::Message&) override {}
  void on_frame(Time, const KeepAlive&) override {}
  void on_frame(Time, const ChallengeFrame&) override {}
  void on_frame(Time, const ResponseFrame&) override {}
  void on_frame(Time, const CloseFrame&) override {}
  void on_frame(Time, const PauseFrame&) override {}
  void on_lost(Time, const Header& header, core::Outcome) override {
    lost.push_back(header.seq_nr);
  }

  void push(std::uint8_t seq, std::size_t size, std::uint32_t src = 1) {
    Header header{.seq_nr = seq, .src = Address(src), .length = static_cast<std::uint32_t>(size)};
    std::vector<std::byte> bytes(size);
    wire::encode_header(header, std::span(bytes).first<kHeaderSize>());
    sender.push(now, 0, header, bytes);
  }
  // The pieces of all that is to be sent, as they go out.
  struct Piece {
    SampleFrame frame{};
    std::vector<std::byte> bytes{};
    Range range{};
    bool again = false;
  };
  std::vector<Piece> take(std::size_t size) {
    std::vector<Piece> pieces;
    while (const auto next = sender.next(size, number)) {
      Piece piece{next->frame, std::vector<std::byte>(next->size), next->range(), next->again};
      sender.read(*next, piece.bytes);
      sender.sent(now, *next);
      pieces.push_back(std::move(piece));
    }
    EXPECT_FALSE(sender.wants_to_send());
    return pieces;
  }
  void acknowledge(const std::vector<Piece>& pieces) {
    for (const Piece& piece : pieces) sender.on_acked(piece.range);
  }
  bool deliver(Piece& piece) {
    piece.frame.bytes = piece.bytes;
    const bool ok = receiver.on_frame(now, piece.frame);
    done.clear();
    return ok;
  }

  struct alignas(core::BlockPool::kBlockSize) Blocks {
    std::array<std::byte, 1U << 20> bytes;
  };
  std::unique_ptr<Blocks> blocks = std::make_unique<Blocks>();
  std::vector<std::byte> messages = std::vector<std::byte>(MessageMemory::kPlacesMin << 20);
  core::BlockPool pool{blocks->bytes};
  MessageMemory memory{messages, 1U << 20, 4U << 20};
  std::vector<MessageBuffer> done;
  Reassembly reassembly{pool, memory, done};
  SampleSender sender{pool, *this};
  SampleReceiver receiver{reassembly, *this};
  std::uint32_t number = 0;
  std::vector<std::uint8_t> arrived;
  std::vector<std::uint8_t> lost;
  Time now{100s};
};

TEST_F(SamplesTest, ANewerOneTakesThePlaceOfOneThatWasTried) {
  push(1, 100);
  push(2, 100);
  EXPECT_TRUE(lost.empty());  // no attempt to send yet
  sender.congested();
  push(3, 100);
  EXPECT_EQ(lost, (std::vector<std::uint8_t>{1, 2}));
  push(4, 100, 2);  // another stream
  for (Piece& piece : take(2000)) deliver(piece);
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{3, 4}));
  EXPECT_EQ(pool.used(), 0U);
}

// Else what is fast would be sent again and again, and the others never.
TEST_F(SamplesTest, ANewerOneIsSentInTheTurnOfTheOlder) {
  push(1, 100, 1);
  push(2, 100, 2);
  push(3, 100, 3);
  sender.congested();
  push(4, 100, 2);
  push(5, 100, 1);
  push(6, 100, 1);
  for (Piece& piece : take(2000)) deliver(piece);
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{5, 4, 3, 6}));
}

TEST_F(SamplesTest, ANewerOneIsSentBehindThoseOfItsStreamThatStay) {
  push(1, 100, 1);
  sender.congested();
  push(2, 100, 2);
  push(3, 100, 1);  // in the place of the first, where nothing replaces it
  push(4, 100, 1);
  EXPECT_EQ(lost, (std::vector<std::uint8_t>{1}));
  for (Piece& piece : take(2000)) deliver(piece);
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{3, 2, 4}));
  EXPECT_EQ(receiver.overtaken(), 0U);
}

TEST_F(SamplesTest, WhatHasBegunIsFinished) {
  push(1, 100);
  sender.sent(now, sender.next(50, number).value());
  sender.congested();
  EXPECT_EQ(sender.droppable_bytes(), 0U);
  EXPECT_FALSE(sender.drop_one(now));
  push(2, 100);
  EXPECT_TRUE(lost.empty());
  EXPECT_TRUE(sender.drop_one(now));
  EXPECT_EQ(lost, (std::vector<std::uint8_t>{2})) << "it waits behind it";
  for (Piece& piece : take(50)) EXPECT_EQ(piece.frame.offset, 50U);
}

TEST_F(SamplesTest, PartsInAnyOrder) {
  push(1, 5000);
  auto pieces = take(1000);
  ASSERT_EQ(pieces.size(), 5U);
  for (const std::size_t i : {4U, 0U, 4U, 3U, 1U, 2U}) EXPECT_TRUE(deliver(pieces[i]));
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{1}));
  EXPECT_EQ(memory.used_bytes(), 0U);
}

// Memory was allocated for the size stated in the first part.
TEST_F(SamplesTest, AllPartsSayTheSameSize) {
  push(1, 5000);
  auto pieces = take(1000);
  EXPECT_TRUE(deliver(pieces[0]));
  pieces[4].frame.total = 500'000;
  pieces[4].frame.offset = 499'000;
  EXPECT_FALSE(deliver(pieces[4]));
  EXPECT_TRUE(arrived.empty());
}

TEST_F(SamplesTest, WhatIsTooLargeOrNoMessageBreaksTheLink) {
  reassembly.message_max = 5000;
  push(1, 5000);
  push(2, 5001);
  push(3, 100);
  auto pieces = take(1000);
  ASSERT_EQ(pieces.size(), 12U);
  EXPECT_TRUE(deliver(pieces[0]));
  EXPECT_FALSE(deliver(pieces[5]));
  pieces[11].bytes.resize(99);
  pieces[11].frame.total = 99;
  EXPECT_FALSE(deliver(pieces[11])) << "its header states 100";
}

TEST_F(SamplesTest, AnOlderOneIsNotHandedOn) {
  push(1, 100);
  push(2, 100);
  auto pieces = take(2000);
  deliver(pieces[1]);
  deliver(pieces[0]);
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{2}));
  EXPECT_EQ(receiver.overtaken(), 1U);
}

TEST_F(SamplesTest, TheRestIsNotWaitedForForEver) {
  push(1, 5000);
  auto pieces = take(1000);
  deliver(pieces[0]);
  receiver.expire(now + kSamplePatience - 1ns);
  EXPECT_GT(memory.used_bytes(), 0U);
  receiver.expire(now + kSamplePatience);
  EXPECT_EQ(memory.used_bytes(), 0U);
  EXPECT_EQ(receiver.incomplete(), 1U);
  for (Piece& piece : pieces) EXPECT_TRUE(deliver(piece));
  EXPECT_EQ(memory.used_bytes(), 0U) << "and does not begin again";
  EXPECT_TRUE(arrived.empty());
}

// On a slow line a large one takes long.
TEST_F(SamplesTest, WhatGoesOnIsWaitedFor) {
  push(1, 5 * LaneReceiver::kProgress);
  for (Piece& piece : take(LaneReceiver::kProgress)) {
    deliver(piece);
    now += kSamplePatience - 1ns;
    receiver.expire(now);
  }
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{1}));
  push(2, 5000);
  auto pieces = take(1000);
  for (std::size_t i = 0; i < 3; ++i) {
    deliver(pieces[i]);
    now += kSamplePatience / 2;
    receiver.expire(now);
  }
  EXPECT_EQ(receiver.incomplete(), 1U) << "a little now and then is no progress";
}

TEST_F(SamplesTest, WhatWasLostOfOneIsSentAgain) {
  push(1, 5000);
  auto pieces = take(1000);
  for (const std::size_t i : {0U, 2U, 4U}) {
    deliver(pieces[i]);
    sender.on_acked(pieces[i].range);
  }
  EXPECT_FALSE(sender.wants_to_send()) << "nobody knows yet";
  push(2, 100, 2);
  sender.on_lost(pieces[1].range);
  sender.on_lost(pieces[3].range);
  auto again = take(600);
  ASSERT_EQ(again.size(), 5U) << "each in two, and the new one";
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(again[i].again);
    EXPECT_EQ(again[i].frame.number, pieces[0].frame.number);
    EXPECT_TRUE(deliver(again[i]));
  }
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{1}));
  EXPECT_FALSE(again[4].again);
  again.pop_back();
  EXPECT_EQ(sender.bytes(), 5000U);
  acknowledge(again);
  EXPECT_TRUE(sender.is_idle());
  EXPECT_EQ(sender.bytes(), 0U);
  EXPECT_EQ(pool.used(), 0U);
  sender.on_lost(pieces[1].range);  // it was declared lost too early
  sender.on_acked(pieces[3].range);
  EXPECT_FALSE(sender.wants_to_send());
}

TEST_F(SamplesTest, OneThatFitsIntoADatagramIsSentOnce) {
  push(1, 1000);
  push(2, 1000);
  const auto pieces = take(1000);
  EXPECT_TRUE(sender.is_idle());
  EXPECT_EQ(pool.used(), 0U);
  for (const Piece& piece : pieces) sender.on_lost(piece.range);
  EXPECT_FALSE(sender.wants_to_send());
}

TEST_F(SamplesTest, WhatIsLostOfOneThatIsStillBeingSentComesFirst) {
  push(1, 3000);
  const auto first = sender.next(1000, number).value();
  sender.sent(now, first);
  sender.on_lost(first.range());
  const auto pieces = take(1000);
  ASSERT_EQ(pieces.size(), 3U);
  EXPECT_EQ(pieces[0].frame.offset, 0U);
  EXPECT_EQ(pieces[1].frame.offset, 1000U);
  EXPECT_EQ(pieces[2].frame.offset, 2000U);
}

TEST_F(SamplesTest, ANewerOneThatHasComeWholeEndsTheOlder) {
  push(1, 5000, 1);
  push(2, 5000, 2);
  const auto older = take(1000);
  push(3, 5000, 1);
  const auto newer = take(1000);
  for (const Piece& piece : older) sender.on_lost(piece.range);
  EXPECT_EQ(sender.bytes(), 15'000U);
  acknowledge(newer);
  EXPECT_EQ(sender.bytes(), 5000U);
  const auto again = take(5000);
  ASSERT_EQ(again.size(), 1U) << "of the other stream";
  EXPECT_EQ(again[0].frame.number, older[5].frame.number);
  EXPECT_TRUE(lost.empty()) << "they were sent";
}

TEST_F(SamplesTest, WhatWasSentIsKeptForAWhile) {
  push(1, 5000);
  now += 10s;  // it waited
  const auto pieces = take(1000);
  sender.expire(now + kSamplePatience - 1ns, 30s);
  for (const Piece& piece : pieces) sender.on_lost(piece.range);
  EXPECT_TRUE(sender.wants_to_send());
  sender.expire(now + kSamplePatience, 30s);
  EXPECT_FALSE(sender.wants_to_send());
  EXPECT_TRUE(sender.is_idle());
  EXPECT_EQ(pool.used(), 0U);
  EXPECT_TRUE(lost.empty());
}

TEST_F(SamplesTest, OfWhatWasSentNoMoreIsKept) {
  push(1, 200);
  const auto first = take(100);
  const auto fill = [&](std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) push(2, 200);
    (void)take(100);
  };
  fill(SampleSender::kKeptMax - 2);
  EXPECT_EQ(sender.bytes(), (SampleSender::kKeptMax - 1) * 200);
  fill(1);
  EXPECT_EQ(sender.bytes(), SampleSender::kKeptMax * 200);
  for (const Piece& piece : first) sender.on_lost(piece.range);
  EXPECT_EQ(take(100).size(), 2U) << "it is still there";
  fill(1);
  EXPECT_EQ(sender.bytes(), SampleSender::kKeptMax * 200);
  for (const Piece& piece : first) sender.on_lost(piece.range);
  EXPECT_EQ(take(100).size(), 0U) << "the oldest went";
}

// The only cost is the repetition.
TEST_F(SamplesTest, WhatWasSentIsDroppedFirst) {
  push(1, 50'000);
  const auto sent = take(1000);
  push(2, 50'000, 2);
  const std::size_t used = pool.used();
  EXPECT_EQ(sender.droppable_bytes(), 100'000U);
  EXPECT_TRUE(sender.drop_one(now));
  EXPECT_TRUE(lost.empty());
  EXPECT_LE(pool.used(), used / 2 + 1);
  EXPECT_TRUE(sender.drop_one(now));
  EXPECT_EQ(lost, (std::vector<std::uint8_t>{2}));
  EXPECT_FALSE(sender.drop_one(now));
  EXPECT_EQ(pool.used(), 0U);
}

// Cameras are faster than the line: what was replaced takes no memory behind what is being sent.
TEST_F(SamplesTest, WhatWasReplacedGivesItsMemoryBack) {
  push(1, 50'000);
  sender.sent(now, sender.next(1000, number).value());
  for (std::uint8_t i = 2; i < 100; ++i) {
    push(i, 50'000);
    sender.congested();
  }
  EXPECT_EQ(sender.bytes(), 100'000U);
  EXPECT_LE(pool.used(), 100'000U / core::BlockPool::kBlockSize + 4);
  EXPECT_EQ(lost.size(), 97U);
}

TEST_F(SamplesTest, WhatComesAgainAfterItWasHandedOnIsNothing) {
  push(1, 5000);
  auto pieces = take(1000);
  for (int time = 0; time < 2; ++time)
    for (Piece& piece : pieces) EXPECT_TRUE(deliver(piece));
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{1}));
  EXPECT_EQ(memory.used_bytes(), 0U);
  EXPECT_EQ(receiver.overtaken(), 0U);
}

TEST_F(SamplesTest, WhatWasSentInPartsMayComeAgainInOne) {
  push(1, 1000);
  auto pieces = take(600);
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_TRUE(deliver(pieces[0]));
  for (const Piece& piece : pieces) sender.on_lost(piece.range);
  auto again = take(1000);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_TRUE(deliver(again[0]));
  EXPECT_EQ(memory.used_bytes(), 0U);
  for (const Piece& piece : again) sender.on_lost(piece.range);
  again = take(1000);
  ASSERT_EQ(again.size(), 1U) << "as often as it is lost";
  EXPECT_TRUE(deliver(again[0]));
  EXPECT_TRUE(deliver(pieces[1]));
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{1}));
  EXPECT_EQ(memory.used_bytes(), 0U);
}

TEST_F(SamplesTest, AnOlderOneInPartIsNotWaitedFor) {
  push(1, 5000, 1);
  push(2, 5000, 2);
  push(3, 100, 1);
  auto pieces = take(1000);
  deliver(pieces[0]);
  deliver(pieces[5]);
  deliver(pieces[10]);
  EXPECT_EQ(receiver.overtaken(), 1U);
  for (std::size_t i = 1; i < 10; ++i) EXPECT_TRUE(deliver(pieces[i]));
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{3, 2}));
  EXPECT_EQ(memory.used_bytes(), 0U);
}

TEST_F(SamplesTest, NumbersRunOnPastTheirEnd) {
  number = 0xFFFFFFFE;
  for (std::uint8_t i = 0; i < 4; ++i) push(i, 100);
  for (Piece& piece : take(2000)) {
    EXPECT_NE(piece.frame.number, 0U);
    EXPECT_TRUE(deliver(piece));
  }
  EXPECT_EQ(arrived.size(), 4U);
}

}  // namespace samples_test
}  // namespace tims::link
