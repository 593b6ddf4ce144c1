// Compression of single blocks by LZ4 or zstd, after a filter (shuffle.h). No history is shared
// between blocks: each can be lost, and none reveals anything about another one.
//
// Everything to be decompressed is hostile. The caller states the exact size of the result; no size
// in the compressed bytes is believed, and no more memory is used than that.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "router/compression/shuffle.h"

namespace tims::compression {

enum class Method : std::uint8_t { kLz4, kZstd };
std::string_view name(Method method);  // "lz4", "zstd"

struct Recipe {
  Method method = Method::kLz4;
  bool delta = false;
  std::uint8_t stride = 1;
  bool operator==(const Recipe&) const = default;
};

// Two bytes: method and delta, stride. Empty: not a recipe.
inline constexpr std::size_t kRecipeSize = 2;
void encode(const Recipe& recipe, std::span<std::byte, kRecipeSize> to);
std::optional<Recipe> decode_recipe(std::span<const std::byte, kRecipeSize> from);

// What a filter needs is worth its time with this method: zstd gains from differences, LZ4, which
// only finds repetitions, loses by them.
Recipe recipe_for(Method method, std::size_t stride);

inline constexpr std::size_t kBlockMax = std::size_t{1} << 20;
// More than the best real data reach (a map without obstacles: 19), so more is an attack.
inline constexpr std::size_t kRatioMax = 255;

// All memory is allocated by the constructor: 1 MiB for the filter, and what the libraries need
// (0.8 MiB). Not for several threads at once.
class Codec {
 public:
  Codec();
  ~Codec();
  Codec(const Codec&) = delete;
  Codec& operator=(const Codec&) = delete;

  // Returns the number of bytes written to `to`; 0 when they do not fit there, when the ratio is
  // above kRatioMax, or when `from` is longer than kBlockMax.
  std::size_t compress(const Recipe& recipe, std::span<const std::byte> from,
                       std::span<std::byte> to);
  // Returns false unless the result has exactly the size of `to`, which is then filled. Otherwise
  // the contents of `to` are undefined.
  [[nodiscard]] bool decompress(const Recipe& recipe, std::span<const std::byte> from,
                                std::span<std::byte> to);

 private:
  struct Libraries;

  std::unique_ptr<std::byte[]> filtered_;
  std::unique_ptr<Libraries> libraries_;
};

}  // namespace tims::compression
