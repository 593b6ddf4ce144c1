// Samples of streams, out and in.
#include "router/link/samples.h"

#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "wire/header.h"

namespace tims::link {
namespace {

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
  void on_lost(Time, const Header& header, core::Outcome) override {
    lost.push_back(header.seq_nr);
  }

  void push(std::uint8_t seq, std::size_t size, std::uint32_t src = 1) {
    Header header{.seq_nr = seq, .src = Address(src), .length = static_cast<std::uint32_t>(size)};
    std::vector<std::byte> bytes(size);
    wire::encode_header(header, std::span(bytes).first<kHeaderSize>());
    sender.push(now, 0, header, bytes);
  }
  // The pieces of all that waits, as they go out.
  struct Piece {
    SampleFrame frame{};
    std::vector<std::byte> bytes{};
  };
  std::vector<Piece> take(std::size_t size) {
    std::vector<Piece> pieces;
    while (!sender.empty()) {
      const auto next = sender.next(size, number);
      Piece piece{next.frame, std::vector<std::byte>(next.size)};
      sender.read(next, piece.bytes);
      sender.sent(next);
      pieces.push_back(std::move(piece));
    }
    return pieces;
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
  EXPECT_TRUE(lost.empty());  // nobody has tried yet
  sender.congested();
  push(3, 100);
  EXPECT_EQ(lost, (std::vector<std::uint8_t>{1, 2}));
  push(4, 100, 2);  // another stream
  for (Piece& piece : take(2000)) deliver(piece);
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{3, 4}));
  EXPECT_EQ(pool.used(), 0U);
}

TEST_F(SamplesTest, WhatHasBegunIsFinished) {
  push(1, 100);
  auto first = sender.next(50, number);
  sender.sent(first);
  sender.congested();
  EXPECT_FALSE(sender.can_drop_oldest());
  push(2, 100);
  EXPECT_TRUE(lost.empty());
}

TEST_F(SamplesTest, PartsInAnyOrder) {
  push(1, 5000);
  auto pieces = take(1000);
  ASSERT_EQ(pieces.size(), 5U);
  for (const std::size_t i : {4U, 0U, 3U, 1U, 2U}) EXPECT_TRUE(deliver(pieces[i]));
  EXPECT_EQ(arrived, (std::vector<std::uint8_t>{1}));
  EXPECT_EQ(memory.used_bytes(), 0U);
}

// Memory was taken for what the first part said.
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
  EXPECT_FALSE(deliver(pieces[11])) << "its header says 100";
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
  receiver.expire(now + SampleReceiver::kPatience - 1ns);
  EXPECT_GT(memory.used_bytes(), 0U);
  receiver.expire(now + SampleReceiver::kPatience);
  EXPECT_EQ(memory.used_bytes(), 0U);
  EXPECT_EQ(receiver.incomplete(), 1U);
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

}  // namespace
}  // namespace tims::link
