#include "router/compression/shuffle.h"

#include <cstring>
#include <vector>

#include <gtest/gtest.h>

namespace tims::compression {
namespace shuffle_test {

std::vector<std::byte> numbered(std::size_t size) {
  std::vector<std::byte> bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * 7 + i / 256);
  return bytes;
}

TEST(Shuffle, PutsTheSamePlaceOfAllStructsTogether) {
  const std::vector<std::byte> from{std::byte{1}, std::byte{2}, std::byte{3}, std::byte{4},
                                    std::byte{5}, std::byte{6}, std::byte{7}};
  std::vector<std::byte> to(from.size());
  shuffle(from, 3, to);
  EXPECT_EQ(to, (std::vector<std::byte>{std::byte{1}, std::byte{4}, std::byte{2}, std::byte{5},
                                        std::byte{3}, std::byte{6}, std::byte{7}}));
}

TEST(Shuffle, IsUndoneForEveryStrideAndSize) {
  for (std::size_t stride = 0; stride <= kStrideMax; ++stride) {
    for (const std::size_t size : {0U, 1U, 15U, 16U, 19U, 20U, 21U, 47U, 48U, 49U, 500U}) {
      const std::vector<std::byte> from = numbered(size);
      std::vector<std::byte> shuffled(size);
      std::vector<std::byte> back(size);
      shuffle(from, stride, shuffled);
      unshuffle(shuffled, stride, back);
      EXPECT_EQ(back, from) << "stride " << stride << ", size " << size;
    }
  }
}

TEST(Shuffle, DifferencesAreUndone) {
  for (const std::size_t size : {0U, 1U, 2U, 700U}) {
    const std::vector<std::byte> from = numbered(size);
    std::vector<std::byte> bytes = from;
    subtract(bytes);
    if (size > 2) {
      EXPECT_EQ(bytes[1], std::byte{7});
    }
    add_up(bytes);
    EXPECT_EQ(bytes, from);
  }
}

struct Point {
  float angle;
  std::int32_t distance;
  std::int32_t type;
  std::int32_t intensity;
};

TEST(FindStride, IsTheSizeOfTheStructs) {
  std::vector<std::byte> bytes(24 + 100 * sizeof(Point));
  for (int i = 0; i < 100; ++i) {
    const Point point{static_cast<float>(i) * 0.01F, 4000 + i * i, 0, 0};
    std::memcpy(bytes.data() + 24 + static_cast<std::size_t>(i) * sizeof(Point), &point,
                sizeof(Point));
  }
  EXPECT_EQ(find_stride(bytes), sizeof(Point));
}

TEST(FindStride, IsOneWithoutStructs) {
  EXPECT_EQ(find_stride({}), 1U);
  EXPECT_EQ(find_stride(std::vector<std::byte>(1)), 1U);
  EXPECT_EQ(find_stride(std::vector<std::byte>(2000)), 1U) << "of equal bytes";
}

}  // namespace shuffle_test
}  // namespace tims::compression
