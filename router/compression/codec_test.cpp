#include "router/compression/codec.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <zstd.h>

#include "router/compression/sample_bytes.h"

namespace tims::compression {
namespace codec_test {

constexpr std::array kMethods{Method::kLz4, Method::kZstd};

std::vector<std::byte> compressed(Codec& codec, const Recipe& recipe,
                                  std::span<const std::byte> from, std::size_t room) {
  std::vector<std::byte> to(room);
  to.resize(codec.compress(recipe, from, to));
  return to;
}

TEST(Codec, WhatIsCompressedIsRestored) {
  Codec codec;
  for (const Method method : kMethods) {
    for (const std::size_t size : {600U, 5784U, 70'000U, 1U << 20}) {
      const std::vector<std::byte> from = scan_like(size);
      const Recipe recipe = recipe_for(method, find_stride(from));
      EXPECT_EQ(recipe.stride, 16);
      const auto packed = compressed(codec, recipe, from, size);
      ASSERT_FALSE(packed.empty());
      EXPECT_LT(packed.size(), size / 3);
      std::vector<std::byte> back(size);
      EXPECT_TRUE(codec.decompress(recipe, packed, back));
      EXPECT_EQ(back, from);
    }
  }
}

TEST(Codec, IsNeverLargerThanTheRoom) {
  Codec codec;
  for (const Method method : kMethods) {
    EXPECT_EQ(compressed(codec, {.method = method}, noise(2000), 2000).size(), 0U);
    const auto from = scan_like(2000);
    const std::size_t size = compressed(codec, {.method = method}, from, 2000).size();
    ASSERT_GT(size, 0U);
    EXPECT_EQ(compressed(codec, {.method = method}, from, size - 1).size(), 0U);
  }
}

TEST(Codec, BlocksHaveABound) {
  Codec codec;
  for (const Method method : kMethods) {
    EXPECT_GT(compressed(codec, {.method = method}, scan_like(kBlockMax), kBlockMax).size(), 0U);
    EXPECT_EQ(compressed(codec, {.method = method}, scan_like(kBlockMax + 1), kBlockMax).size(),
              0U);
    EXPECT_EQ(compressed(codec, {.method = method}, {}, 100).size(), 0U);
  }
}

// A kilobyte can become 32 MB with zstd. We neither take nor send what exceeds the ratio.
TEST(Codec, BombsAreRefused) {
  Codec codec;
  const std::vector<std::byte> zeros(kBlockMax);
  std::vector<std::byte> bomb(ZSTD_compressBound(zeros.size()));
  bomb.resize(ZSTD_compress(bomb.data(), bomb.size(), zeros.data(), zeros.size(), 19));
  ASSERT_LT(bomb.size() * kRatioMax, zeros.size());
  std::vector<std::byte> to(kBlockMax);
  EXPECT_FALSE(codec.decompress({.method = Method::kZstd}, bomb, to));
  EXPECT_EQ(compressed(codec, {.method = Method::kZstd}, zeros, kBlockMax).size(), 0U);
  EXPECT_FALSE(codec.decompress({}, std::vector<std::byte>(10), std::span(to).first(2551)));
}

TEST(Codec, OnlyTheExactSizeIsTaken) {
  Codec codec;
  const auto from = scan_like(3000);
  for (const Method method : kMethods) {
    const Recipe recipe = recipe_for(method, 16);
    const auto packed = compressed(codec, recipe, from, from.size());
    for (const std::size_t size : {1U, 2999U, 3001U, 6000U}) {
      std::vector<std::byte> to(size);
      EXPECT_FALSE(codec.decompress(recipe, packed, to)) << size;
    }
    std::vector<std::byte> to(3000);
    EXPECT_FALSE(codec.decompress(recipe, std::span(packed).first(packed.size() - 1), to));
    EXPECT_FALSE(codec.decompress(recipe, {}, to));
    EXPECT_FALSE(codec.decompress(recipe, packed, {}));
    EXPECT_TRUE(codec.decompress(recipe, packed, to)) << "it works again after errors";
    EXPECT_EQ(to, from);
  }
}

TEST(Codec, RecipesAreTwoBytes) {
  std::array<std::byte, kRecipeSize> bytes{};
  for (const Method method : kMethods) {
    for (const bool delta : {false, true}) {
      for (const unsigned stride : {0U, 1U, 16U, 48U}) {
        const Recipe recipe{
            .method = method, .delta = delta, .stride = static_cast<std::uint8_t>(stride)};
        encode(recipe, bytes);
        EXPECT_EQ(decode_recipe(bytes), recipe);
      }
    }
  }
  EXPECT_FALSE(decode_recipe(std::array{std::byte{2}, std::byte{1}})) << "no such method";
  EXPECT_FALSE(decode_recipe(std::array{std::byte{0}, std::byte{49}})) << "stride too large";
}

}  // namespace codec_test
}  // namespace tims::compression
