#include "components/devices/core/datagram_assembly.h"

#include <algorithm>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

namespace rack::device {
namespace datagram_assembly_test {

std::vector<std::byte> bytes_of(std::size_t size) {
  std::vector<std::byte> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 7 % 251);
  return bytes;
}

// Fragments of 1480 bytes, as Ethernet has them, of a datagram of any size and in any order.
TEST(DatagramAssemblyTest, FragmentsInAnyOrderAndTwiceAreOneDatagram) {
  constexpr std::size_t kPiece = 1480;
  std::mt19937 random(1);
  DatagramAssembly assembly;
  for (const std::size_t size : {std::size_t{1}, kPiece, kPiece + 1, 24896UL, 65535UL}) {
    const auto whole = bytes_of(size);
    std::vector<std::size_t> pieces((size + kPiece - 1) / kPiece);
    std::iota(pieces.begin(), pieces.end(), 0);
    std::ranges::shuffle(pieces, random);
    bool is_complete = false;
    const auto add = [&](std::size_t piece) {
      const std::size_t offset = piece * kPiece;
      const std::size_t length = std::min(kPiece, size - offset);
      const auto datagram = assembly.add({.key = {.id = static_cast<std::uint32_t>(size)},
                                          .offset = offset,
                                          .is_last = offset + length == size,
                                          .bytes = std::span(whole).subspan(offset, length)});
      if (datagram) is_complete = std::ranges::equal(*datagram, whole);
    };
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      EXPECT_FALSE(is_complete) << size;
      if (i + 1 < pieces.size()) add(pieces[i]);
      add(pieces[i]);
    }
    EXPECT_TRUE(is_complete) << size;
  }
  EXPECT_EQ(assembly.incomplete(), 0U);
}

TEST(DatagramAssemblyTest, WhatIsNeverCompleteIsBoundedAndCounted) {
  DatagramAssembly assembly;
  const std::vector<std::byte> piece(8);
  for (std::uint32_t id = 0; id < 1000; ++id)
    EXPECT_FALSE(assembly.add({.key = {.id = id}, .offset = 65520, .bytes = piece}));
  EXPECT_EQ(assembly.incomplete(), 1000U);
}

TEST(DatagramAssemblyTest, InvalidFragmentsAreRefused) {
  DatagramAssembly assembly;
  const auto bytes = bytes_of(16);
  const auto add = [&](std::size_t offset, std::size_t size, bool is_last) {
    return assembly
        .add({.offset = offset, .is_last = is_last, .bytes = std::span(bytes).first(size)})
        .has_value();
  };
  EXPECT_FALSE(add(65528, 8, true));  // 65536 bytes
  EXPECT_FALSE(add(0, 7, false));     // ends between two units
  EXPECT_FALSE(add(4, 8, true));      // begins between two units
  EXPECT_EQ(assembly.incomplete(), 3U);
  EXPECT_FALSE(add(0, 16, false));
  EXPECT_FALSE(add(0, 8, true)) << "ends before bytes that it has";
  EXPECT_TRUE(add(16, 0, true));
}

}  // namespace datagram_assembly_test
}  // namespace rack::device
