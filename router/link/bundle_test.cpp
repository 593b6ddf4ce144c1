#include "router/link/bundle.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace tims::link {
namespace {

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> made;
  for (const int value : values) made.push_back(static_cast<std::byte>(value));
  return made;
}

std::string sizes(std::vector<std::byte> of) {
  std::string text;
  Bundle(of).for_each(
      [&](std::span<std::byte> datagram) { text += std::to_string(datagram.size()) + " "; });
  return text;
}

TEST(Bundle, DatagramsOneBehindTheOther) {
  auto two = bytes({1, 0, 0xAA, 2, 0, 0xBB, 0xCC});
  EXPECT_TRUE(Bundle(two).valid());
  EXPECT_EQ(sizes(two), "1 2 ");
  std::vector<std::byte> second;
  Bundle(two).for_each([&](std::span<std::byte> d) { second.assign(d.begin(), d.end()); });
  EXPECT_EQ(second, bytes({0xBB, 0xCC}));
}

TEST(Bundle, TheLargestDatagram) {
  std::vector<std::byte> large(kBundleSizeBytes + kBundledMax);
  large[0] = large[1] = std::byte{0xFF};
  EXPECT_TRUE(Bundle(large).valid());
  EXPECT_EQ(sizes(large), "65535 ");
}

TEST(Bundle, ZerosUpToAMultipleOfFour) {
  for (auto padded :
       {bytes({1, 0, 9, 0}), bytes({2, 0, 9, 0, 0, 0}), bytes({3, 0, 0, 0, 0, 0, 0, 0})}) {
    EXPECT_TRUE(Bundle(padded).valid()) << "of " << padded.size() << " bytes";
    EXPECT_EQ(sizes(padded), std::to_string(std::to_integer<int>(padded[0])) + " ");
  }
}

TEST(Bundle, BytesThatAreNone) {
  for (auto bad :
       {bytes({}), bytes({1}), bytes({1, 0}), bytes({0, 0}), bytes({2, 0, 1}), bytes({1, 0, 9, 1}),
        bytes({1, 0, 9, 0, 0, 1}), bytes({1, 0, 9, 5, 0, 1}), bytes({0, 0, 1, 0, 9}),
        bytes({1, 0, 9, 0, 0, 0, 0}), bytes({0xFF, 0xFF, 1, 2, 3})}) {
    EXPECT_FALSE(Bundle(bad).valid()) << "of " << bad.size() << " bytes";
  }
}

}  // namespace
}  // namespace tims::link
