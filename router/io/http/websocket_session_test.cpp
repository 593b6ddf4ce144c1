#include "router/io/http/websocket_session.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "wire/header.h"

namespace tims::io {
namespace websocket_session_test {

using core::BlockPool;
using core::Outcome;

// A message of `size` bytes whose body repeats its name.
std::vector<std::byte> message(char name, std::size_t size = 20, std::uint8_t priority = 0) {
  std::vector<std::byte> bytes(size, static_cast<std::byte>(name));
  const Header header{.priority = priority, .length = static_cast<std::uint32_t>(size)};
  wire::encode_header(header, std::span(bytes).first<kHeaderSize>());
  return bytes;
}

class WebSocketOutputTest : public testing::Test, private core::QueueOwner {
 protected:
  void on_dropped(const core::LossCounts& lost) override { output_.add_replaced(lost); }
  void give_up() override {}
  static constexpr std::size_t kBlocks = 1000;

  Outcome add(char name, std::size_t size = 20, std::uint8_t priority = 0) {
    return output_.add(message(name, size, priority), priority);
  }
  // The bytes of the next frame, which stays begun.
  std::vector<std::byte> begin() {
    std::vector<std::byte> bytes;
    const auto frame = output_.begin_frame();
    last_ = frame && frame->last;
    if (!frame) return bytes;
    EXPECT_LE(frame->pieces.size(), kFramePiecesMax);
    for (const auto piece : frame->pieces) bytes.insert(bytes.end(), piece.begin(), piece.end());
    return bytes;
  }
  // All frames of the next message.
  std::vector<std::byte> take() {
    std::vector<std::byte> bytes;
    frames_ = 0;
    do {
      const auto frame = begin();
      if (frame.empty()) break;
      ++frames_;
      output_.end_frame();
      bytes.insert(bytes.end(), frame.begin(), frame.end());
    } while (!last_);
    return bytes;
  }

  std::unique_ptr<std::byte[]> memory_{
      std::make_unique<std::byte[]>((kBlocks + 1) * BlockPool::kBlockSize)};
  BlockPool pool_{{aligned(memory_.get()), kBlocks* BlockPool::kBlockSize}};
  core::QueueShares shares_{pool_};
  WebSocketOutput output_{shares_, *this, 1 << 20};
  bool last_ = false;
  int frames_ = 0;

 private:
  static std::byte* aligned(std::byte* memory) {
    void* begin = memory;
    std::size_t size = (kBlocks + 1) * BlockPool::kBlockSize;
    return static_cast<std::byte*>(
        std::align(BlockPool::kBlockSize, kBlocks * BlockPool::kBlockSize, begin, size));
  }
};

TEST_F(WebSocketOutputTest, NothingWaits) {
  EXPECT_TRUE(output_.empty());
  EXPECT_FALSE(output_.begin_frame());
}

TEST_F(WebSocketOutputTest, OneMessageIsOneMessage) {
  EXPECT_EQ(add('a'), Outcome::kDelivered);
  EXPECT_EQ(add('b', kHeaderSize), Outcome::kDelivered);
  EXPECT_EQ(add('c', 5000), Outcome::kDelivered);
  EXPECT_EQ(take(), message('a'));
  EXPECT_EQ(take(), message('b', kHeaderSize));
  EXPECT_EQ(take(), message('c', 5000));
  EXPECT_EQ(frames_, 1);
  EXPECT_TRUE(output_.empty());
  EXPECT_EQ(pool_.used(), 0U);
}

// Wherever blocks begin and end.
TEST_F(WebSocketOutputTest, EverySizeAndPosition) {
  for (std::size_t before = 16; before < 4200; before += 37) {
    for (const std::size_t size : {16U, 17U, 31U, 4080U, 4096U, 9000U}) {
      add('x', before);
      add('y', size);
      ASSERT_EQ(take(), message('x', before));
      ASSERT_EQ(take(), message('y', size)) << before << " " << size;
    }
  }
  EXPECT_EQ(pool_.used(), 0U);
}

TEST_F(WebSocketOutputTest, ALargeMessageGoesInFrames) {
  add('a', 1'000'000);
  EXPECT_EQ(take(), message('a', 1'000'000));
  EXPECT_GT(frames_, 3);
}

TEST_F(WebSocketOutputTest, UrgentOnesOvertakeAtTheNextMessage) {
  add('a', 600'000, 1);
  add('b', 20, 1);
  const auto first = begin();
  add('!', 20, 200);
  output_.end_frame();
  auto whole = first;
  const auto rest = take();
  whole.insert(whole.end(), rest.begin(), rest.end());
  EXPECT_EQ(whole, message('a', 600'000, 1));
  EXPECT_EQ(take(), message('!', 20, 200));
  EXPECT_EQ(take(), message('b', 20, 1));
}

TEST_F(WebSocketOutputTest, WhatIsBeingWrittenIsNotReplaced) {
  add('a', 500'000);
  add('b', 500'000);
  const auto frame = output_.begin_frame();
  ASSERT_TRUE(frame);
  EXPECT_EQ(add('c', 500'000, 9), Outcome::kDelivered);
  ASSERT_NE(output_.replaced(), nullptr);
  EXPECT_EQ((*output_.replaced())[1], (core::Count{1, 500'000}));
  // The pieces of the frame still hold what they held.
  EXPECT_EQ(frame->pieces.back().back(), static_cast<std::byte>('a'));
  output_.end_frame();
  while (!last_) {
    begin();
    output_.end_frame();
  }
  EXPECT_EQ(take(), message('c', 500'000, 9));
  EXPECT_TRUE(output_.empty());
}

TEST_F(WebSocketOutputTest, AFullQueueRefusesWhatIsLessImportant) {
  EXPECT_EQ(add('a', 1'000'000, 100), Outcome::kDelivered);
  EXPECT_EQ(add('b', 100'000, 99), Outcome::kQueueFull);
  EXPECT_EQ(take(), message('a', 1'000'000, 100));
}

// Below, at and above the bound of 1 MiB: a larger message may wait, but not two of them.
TEST_F(WebSocketOutputTest, ALargerMessageThanTheQueueWaits) {
  output_.set_queue_bytes_max(500'000);
  for (const std::size_t size : {499'999U, 500'000U, 500'001U, 900'000U}) {
    EXPECT_EQ(add('a', size, 1), Outcome::kDelivered) << size;
    EXPECT_EQ(take(), message('a', size, 1));
  }
  EXPECT_EQ(add('a', 400'000, 9), Outcome::kDelivered);
  EXPECT_EQ(add('b', 600'000, 1), Outcome::kDelivered);
  EXPECT_EQ(add('c', 200'000, 1), Outcome::kQueueFull);
  EXPECT_EQ(add('d', 700'000, 1), Outcome::kDelivered);
  ASSERT_NE(output_.replaced(), nullptr);
  EXPECT_EQ(output_.queued_bytes(), 1'100'000U);
  EXPECT_EQ(take(), message('a', 400'000, 9));
  EXPECT_EQ(take(), message('d', 700'000, 1));
  EXPECT_TRUE(output_.empty());
}

TEST_F(WebSocketOutputTest, WhatIsThrownAwayIsCounted) {
  add('a');
  add('b', 100'000, 255);
  begin();
  output_.end_frame();  // 'b' in one frame
  add('c', 600'000, 255);
  begin();
  output_.end_frame();  // a part of 'c'
  core::LossCounts lost{};
  output_.clear(lost);
  EXPECT_EQ(lost[1], (core::Count{1, 20}));
  EXPECT_EQ(lost[7].messages, 1U);
  EXPECT_TRUE(output_.empty());
  EXPECT_EQ(pool_.used(), 0U);
  // And it can be used again.
  add('d');
  EXPECT_EQ(take(), message('d'));
}

}  // namespace websocket_session_test
}  // namespace tims::io
