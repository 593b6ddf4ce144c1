#include "router/link/datagram_stream.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "router/link/datagram.h"

namespace tims::link {
namespace datagram_stream_test {

using Bytes = std::vector<std::byte>;

Bytes datagram(std::size_t size) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(size + i * 7);
  return bytes;
}

const std::vector<Bytes> kSent{datagram(1),    datagram(255),          datagram(256),
                               datagram(1200), datagram(kDatagramMax), datagram(2)};

TEST(DatagramStream, ArriveWholeHoweverTheBytesAreCut) {
  Bytes all;
  for (const Bytes& one : kSent) DatagramStream::put(one, all);
  for (const std::size_t step : {std::size_t{1}, std::size_t{2}, std::size_t{3}, std::size_t{257},
                                 std::size_t{1500}, all.size()}) {
    DatagramStream stream;
    std::vector<Bytes> arrived;
    Bytes copy = all;
    for (std::span<std::byte> rest = copy; !rest.empty();) {
      const auto part = rest.first(std::min(step, rest.size()));
      rest = rest.subspan(part.size());
      EXPECT_TRUE(stream.feed(
          part, [&](std::span<std::byte> one) { arrived.emplace_back(one.begin(), one.end()); }));
    }
    EXPECT_EQ(arrived, kSent) << step;
  }
}

// They are used until the turn ends, however many follow in the same bytes.
TEST(DatagramStream, WhatWasPassedOnStaysUntilTheNextBytes) {
  Bytes all;
  for (const Bytes& one : kSent) DatagramStream::put(one, all);
  for (std::size_t step = 1; step <= all.size(); step += 1 + step / 16) {
    DatagramStream stream;
    Bytes copy = all;
    std::size_t sent = 0;
    for (std::span<std::byte> rest = copy; !rest.empty();) {
      const auto part = rest.first(std::min(step, rest.size()));
      rest = rest.subspan(part.size());
      std::vector<std::span<std::byte>> passed;
      EXPECT_TRUE(stream.feed(part, [&](std::span<std::byte> one) { passed.push_back(one); }));
      for (const auto& one : passed)
        ASSERT_TRUE(std::ranges::equal(one, kSent[sent++])) << "in steps of " << step;
    }
    ASSERT_EQ(sent, kSent.size());
  }
}

TEST(DatagramStream, ASizeThatNoDatagramHasEndsIt) {
  for (const std::size_t size : {std::size_t{0}, kDatagramMax + 1, std::size_t{0xFFFF}}) {
    for (const bool in_parts : {false, true}) {
      DatagramStream stream;
      Bytes bytes;
      DatagramStream::put(datagram(3), bytes);
      bytes.push_back(static_cast<std::byte>(size));
      bytes.push_back(static_cast<std::byte>(size >> 8));
      bytes.resize(bytes.size() + 10);
      int arrived = 0;
      const auto count = [&](std::span<std::byte>) { ++arrived; };
      const std::size_t cut = in_parts ? 6 : bytes.size();
      const bool first = stream.feed(std::span(bytes).first(cut), count);
      EXPECT_EQ(first, in_parts) << size;
      EXPECT_FALSE(stream.feed(std::span(bytes).subspan(cut), count)) << size;
      EXPECT_FALSE(stream.feed(bytes, count)) << "nothing is understood any more";
      EXPECT_EQ(arrived, 1) << size;
    }
  }
}

}  // namespace datagram_stream_test
}  // namespace tims::link
