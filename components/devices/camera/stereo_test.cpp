#include "components/devices/camera/stereo.h"

#include <array>
#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

namespace rack::device {
namespace stereo_test {

std::size_t at(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
         static_cast<std::size_t>(x);
}

std::byte texture(int x, int y) {
  std::uint32_t hash =
      static_cast<std::uint32_t>(x) * 374761393U + static_cast<std::uint32_t>(y) * 668265263U;
  hash = (hash ^ hash >> 13) * 1274126177;
  return static_cast<std::byte>(hash >> 16 & 0xFF);
}

// Noise at one distance, or `apart_of(x, y)`.
template <typename Apart>
std::vector<std::byte> scene(int width, int height, Apart apart_of) {
  std::vector<std::byte> pair(std::size_t{2} * at(0, height, width));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      pair[at(x, y, 2 * width)] = texture(x, y);
      pair[at(width + x, y, 2 * width)] = texture(x + apart_of(x, y), y);
    }
  return pair;
}

class StereoTest : public testing::TestWithParam<StereoMethod> {};

// A scene of noise at two distances: its right half is nearer.
TEST_P(StereoTest, NearThingsAreFartherApart) {
  constexpr int kWidth = 120;
  constexpr int kHeight = 40;
  const auto pair = scene(kWidth, kHeight, [](int x, int) { return x < 60 - 12 ? 5 : 12; });
  Stereo stereo({.disparities = 32, .block = 7, .method = GetParam()});
  const auto found = stereo.match(pair, kWidth, kHeight);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), pair.size() / 2);
  int right = 0;
  int seen = 0;
  for (int y = 5; y < kHeight - 5; ++y)
    for (const auto& [first, last, apart] : {std::array{12, 44, 5}, std::array{68, 112, 12}})
      for (int x = first; x < last; ++x) {
        const int disparity = (*found)[at(x, y, kWidth)];
        seen += disparity != 0 ? 1 : 0;
        right += disparity != 0 && std::abs(disparity - 16 * apart) <= 8 ? 1 : 0;
      }
  EXPECT_GT(seen, 30 * 70);
  EXPECT_EQ(right, seen);
}

// The margin at the left, where the range of the search is partly outside of the right picture.
TEST_P(StereoTest, AlsoTheLeftMarginIsSeen) {
  constexpr int kWidth = 160;
  constexpr int kHeight = 40;
  const auto pair = scene(kWidth, kHeight, [](int, int) { return 6; });
  Stereo stereo({.disparities = 64, .block = 9, .method = GetParam()});
  const auto found = stereo.match(pair, kWidth, kHeight);
  ASSERT_TRUE(found);
  int seen = 0;
  for (int y = 6; y < kHeight - 6; ++y)
    for (int x = 12; x < 64; ++x) seen += (*found)[at(x, y, kWidth)] / 16 == 6 ? 1 : 0;
  EXPECT_GT(seen, 28 * 52 * 8 / 10);
}

// A match that reaches outside of the right picture at its left cannot be true.
TEST_P(StereoTest, WhatOnlyOneEyeSeesIsNotKnown) {
  constexpr int kWidth = 80;
  constexpr int kHeight = 30;
  const auto pair = scene(kWidth, kHeight, [](int, int) { return 12; });
  Stereo stereo({.disparities = 32, .block = 5, .method = GetParam()});
  const auto found = stereo.match(pair, kWidth, kHeight);
  ASSERT_TRUE(found);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      EXPECT_LE((*found)[at(x, y, kWidth)], std::max(0, x - 2) * 16) << x;
}

TEST(Stereo, ABareWallIsNotKnown) {
  // With the noise of a sensor, in which semi-global matching finds a depth.
  std::vector<std::byte> pair(std::size_t{2} * 128 * 64, std::byte{100});
  Stereo stereo({});
  const auto uniform = stereo.match(pair, 128, 64);
  ASSERT_TRUE(uniform);
  for (const std::uint16_t disparity : *uniform) EXPECT_EQ(disparity, 0);
  for (std::size_t i = 0; i < pair.size(); ++i)
    pair[i] = static_cast<std::byte>(100 + i * 7 % 3 % 2);
  const auto noisy = stereo.match(pair, 128, 64);
  ASSERT_TRUE(noisy);
  for (const std::uint16_t disparity : *noisy) EXPECT_EQ(disparity, 0);
}

// Fewer pixels than a block.
TEST_P(StereoTest, ASmallPictureIsNotKnown) {
  Stereo stereo({.disparities = 16, .block = 5, .method = GetParam()});
  for (const auto& [width, height] :
       {std::array{1, 1}, std::array{5, 5}, std::array{6, 5}, std::array{5, 6}, std::array{6, 6}}) {
    const std::vector<std::byte> pair(std::size_t{2} * at(0, height, width));
    const auto found = stereo.match(pair, width, height);
    ASSERT_TRUE(found) << width << "x" << height;
    EXPECT_EQ(found->size(), pair.size() / 2);
    EXPECT_FALSE(stereo.match(std::span(pair).first(pair.size() - 1), width, height));
  }
  EXPECT_FALSE(stereo.match({}, 0, 0));
}

TEST(Stereo, RangesAreInverse) {
  constexpr int kWidth = 80;
  constexpr int kHeight = 30;
  Stereo stereo({.disparities = 32, .block = 5});
  EXPECT_FALSE(stereo.ranges(1));
  const auto pair = scene(kWidth, kHeight, [](int, int) { return 6; });
  const auto found = stereo.match(pair, kWidth, kHeight);
  ASSERT_TRUE(found);
  const std::vector<std::uint16_t> disparities(found->begin(), found->end());
  const double scale = 100.0 * 60 * 16;  // 100 pixels * 60 mm
  const auto ranges = stereo.ranges(scale);
  ASSERT_TRUE(ranges);
  for (std::size_t i = 0; i < disparities.size(); ++i)
    EXPECT_NEAR((*ranges)[i], disparities[i] == 0 ? 0 : scale / disparities[i], 0.51);
  const auto far = stereo.ranges(1e10);
  ASSERT_TRUE(far);
  for (std::size_t i = 0; i < disparities.size(); ++i)
    EXPECT_EQ((*far)[i], disparities[i] == 0 ? 0 : 65535);
}

INSTANTIATE_TEST_SUITE_P(Both, StereoTest,
                         testing::Values(StereoMethod::kBlock, StereoMethod::kSemiGlobal),
                         [](const auto& one) {
                           return one.param == StereoMethod::kBlock ? "Block" : "SemiGlobal";
                         });

}  // namespace stereo_test
}  // namespace rack::device
