#include "rack/devices/stream_buffer.h"

#include <gtest/gtest.h>

namespace rack::device {
namespace stream_buffer_test {

using namespace std::chrono_literals;

std::vector<std::byte> counted(int first, int count) {
  std::vector<std::byte> bytes;
  bytes.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) bytes.push_back(static_cast<std::byte>(first + i));
  return bytes;
}

TEST(StreamBufferTest, BytesStayInOnePieceAndInOrder) {
  StreamBuffer buffer(10);
  int next = 0;
  int expected = 0;
  for (int round = 0; round < 100; ++round) {
    const auto piece = counted(next, 1 + round % 5);
    next += static_cast<int>(piece.size());
    buffer.add({.bytes = piece});
    while (buffer.size() > 3) {
      EXPECT_EQ(buffer.bytes().front(), static_cast<std::byte>(expected++));
      buffer.consume(1);
    }
  }
  EXPECT_EQ(buffer.size(), 3U);
}

TEST(StreamBufferTest, TheOldestGoWhenItIsFull) {
  StreamBuffer buffer(4);
  buffer.add({.bytes = counted(0, 3)});
  buffer.add({.bytes = counted(3, 3)});
  EXPECT_EQ(std::vector(buffer.bytes().begin(), buffer.bytes().end()), counted(2, 4));
  buffer.add({.bytes = counted(0, 100)});
  EXPECT_EQ(std::vector(buffer.bytes().begin(), buffer.bytes().end()), counted(96, 4));
}

TEST(StreamBufferTest, KnowsWhenAByteWasOnTheLine) {
  StreamBuffer buffer(100);
  buffer.add({.bytes = counted(0, 10), .first = Time(1s), .last = Time(1s + 10ms)});
  EXPECT_EQ(buffer.time_of(0), Time(1s));
  EXPECT_EQ(buffer.time_of(4), Time(1s + 4ms));
  buffer.add({.bytes = counted(0, 10), .first = Time(1s + 10ms), .last = Time(1s + 20ms)});
  EXPECT_EQ(buffer.time_of(0), Time(1s));
  buffer.consume(15);
  EXPECT_EQ(buffer.time_of(0), Time(1s + 15ms));
}

TEST(StreamBufferTest, NumbersInBothOrders) {
  const auto bytes = counted(0xF0, 8);
  EXPECT_EQ(little_endian<std::uint16_t>(bytes), 0xF1F0);
  EXPECT_EQ(big_endian<std::uint16_t>(bytes, 2), 0xF2F3);
  EXPECT_EQ(little_endian<std::int32_t>(bytes), static_cast<std::int32_t>(0xF3F2F1F0));
  EXPECT_EQ(big_endian<std::int8_t>(bytes), -16);
  EXPECT_EQ(big_endian<std::uint64_t>(bytes), 0xF0F1F2F3F4F5F6F7);
}

}  // namespace stream_buffer_test
}  // namespace rack::device
