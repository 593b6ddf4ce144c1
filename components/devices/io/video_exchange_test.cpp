#include "components/devices/io/video_exchange.h"

#include <atomic>
#include <cstring>
#include <thread>

#include <gtest/gtest.h>
#include <sys/mman.h>

namespace rack::device {
namespace video_exchange_test {

void write(FrameWriter& writer, std::uint32_t number, std::size_t size) {
  std::memset(writer.room().data(), static_cast<int>(number & 0xFFU), size);
  writer.publish(
      {.head = {video::kGrey, number, 1, number}, .when = tims::Time(tims::Duration(number))},
      size);
}

class VideoExchangeTest : public testing::Test {
 protected:
  VideoFrame frame_;
  std::vector<std::byte> bytes_;
  FrameReader reader_ = *FrameReader::create();
  FrameWriter writer_ = *FrameWriter::open(reader_.memory());
};

TEST_F(VideoExchangeTest, TheNewestFrameIsTakenOnce) {
  EXPECT_FALSE(*reader_.take(frame_, bytes_));
  for (std::uint32_t i = 1; i < 20; ++i) {
    for (std::uint32_t more = 0; more < i % 4; ++more) write(writer_, 100 + more, 1000);
    write(writer_, i, i);
    ASSERT_TRUE(*reader_.take(frame_, bytes_));
    EXPECT_EQ(frame_.head, (VideoHead{video::kGrey, i, 1, i}));
    EXPECT_EQ(frame_.when, tims::Time(tims::Duration(i)));
    EXPECT_EQ(bytes_, std::vector<std::byte>(i, static_cast<std::byte>(i)));
    EXPECT_FALSE(*reader_.take(frame_, bytes_));
  }
}

TEST_F(VideoExchangeTest, SizesHaveALimit) {
  EXPECT_EQ(writer_.room().size(), kVideoFrameBytesMax);
  write(writer_, 1, kVideoFrameBytesMax);
  ASSERT_TRUE(*reader_.take(frame_, bytes_));
  EXPECT_EQ(bytes_.size(), kVideoFrameBytesMax);
  write(writer_, 2, 0);
  ASSERT_TRUE(*reader_.take(frame_, bytes_));
  EXPECT_TRUE(bytes_.empty());
  // A broken writer.
  writer_.publish({}, kVideoFrameBytesMax + 1);
  EXPECT_EQ(reader_.take(frame_, bytes_).error().code(), tims::Errc::kTooBig);
}

TEST_F(VideoExchangeTest, ABrokenWriterCannotMoveTheReaderOutOfTheMemory) {
  void* const page = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, reader_.memory(), 0);
  ASSERT_NE(page, MAP_FAILED);
  for (const std::uint32_t index : {7U, 0xFFFFFFFFU}) {
    static_cast<std::atomic<std::uint32_t>*>(page)->store(index);
    EXPECT_EQ(reader_.take(frame_, bytes_).error().code(), tims::Errc::kMalformed) << index;
  }
  EXPECT_NE(::ftruncate(reader_.memory(), 0), 0);
  ::munmap(page, 4096);
}

TEST_F(VideoExchangeTest, NoFrameIsMixedWithAnother) {
  constexpr std::uint32_t kFrames = 20'000;
  std::thread thread([&] {
    for (std::uint32_t i = 1; i <= kFrames; ++i) write(writer_, i, 512);
  });
  std::uint32_t last = 0;
  while (last < kFrames) {
    const auto taken = reader_.take(frame_, bytes_);
    ASSERT_TRUE(taken) << taken.error().message();
    if (!*taken) continue;
    const std::uint32_t number = frame_.head.width;
    ASSERT_GT(number, last);
    ASSERT_EQ(bytes_, std::vector<std::byte>(512, static_cast<std::byte>(number & 0xFFU)));
    last = number;
  }
  thread.join();
}

}  // namespace video_exchange_test
}  // namespace rack::device
