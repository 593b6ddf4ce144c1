#include "router/compression/codec.h"

#include <algorithm>
#include <limits>

#include <lz4.h>
// For contexts in memory of the caller, which never allocate.
#define ZSTD_STATIC_LINKING_ONLY
#include <zstd.h>

namespace tims::compression {
namespace {

constexpr int kZstdLevel = 1;
constexpr std::uint8_t kDelta = 0x80;

const char* chars(std::span<const std::byte> bytes) {
  return reinterpret_cast<const char*>(bytes.data());
}
char* chars(std::span<std::byte> bytes) { return reinterpret_cast<char*>(bytes.data()); }

int int_size(std::size_t size) {
  return static_cast<int>(std::min<std::size_t>(size, std::numeric_limits<int>::max()));
}

}  // namespace

std::string_view name(Method method) { return method == Method::kLz4 ? "lz4" : "zstd"; }

void encode(const Recipe& recipe, std::span<std::byte, kRecipeSize> to) {
  to[0] = static_cast<std::byte>(static_cast<unsigned>(recipe.method) |
                                 (recipe.delta ? unsigned{kDelta} : 0U));
  to[1] = static_cast<std::byte>(recipe.stride);
}

std::optional<Recipe> decode_recipe(std::span<const std::byte, kRecipeSize> from) {
  const auto first = std::to_integer<std::uint8_t>(from[0]);
  const auto method = static_cast<std::uint8_t>(first & ~kDelta);
  const Recipe recipe{.method = static_cast<Method>(method),
                      .delta = (first & kDelta) != 0,
                      .stride = std::to_integer<std::uint8_t>(from[1])};
  if (method > static_cast<std::uint8_t>(Method::kZstd) || recipe.stride > kStrideMax)
    return std::nullopt;
  return recipe;
}

Recipe recipe_for(Method method, std::size_t stride) {
  return {.method = method,
          .delta = method == Method::kZstd && stride > 1,
          .stride = static_cast<std::uint8_t>(stride)};
}

// The contexts live in these two blocks.
struct Codec::Libraries {
  std::size_t compressing_bytes = ZSTD_estimateCCtxSize(kZstdLevel);
  std::size_t decompressing_bytes = ZSTD_estimateDCtxSize();
  std::unique_ptr<std::byte[]> compressing_memory =
      std::make_unique_for_overwrite<std::byte[]>(compressing_bytes);
  std::unique_ptr<std::byte[]> decompressing_memory =
      std::make_unique_for_overwrite<std::byte[]>(decompressing_bytes);
  std::unique_ptr<std::byte[]> lz4 =
      std::make_unique_for_overwrite<std::byte[]>(static_cast<std::size_t>(LZ4_sizeofState()));
  ZSTD_CCtx* compressing = ZSTD_initStaticCCtx(compressing_memory.get(), compressing_bytes);
  ZSTD_DCtx* decompressing = ZSTD_initStaticDCtx(decompressing_memory.get(), decompressing_bytes);
};

Codec::Codec()
    : filtered_(std::make_unique_for_overwrite<std::byte[]>(kBlockMax)),
      libraries_(std::make_unique<Libraries>()) {}

Codec::~Codec() = default;

std::size_t Codec::compress(const Recipe& recipe, std::span<const std::byte> from,
                            std::span<std::byte> to) {
  if (from.empty() || from.size() > kBlockMax) return 0;
  std::span<const std::byte> text = from;
  if (recipe.stride > 1 || recipe.delta) {
    const std::span filtered(filtered_.get(), from.size());
    shuffle(from, recipe.stride, filtered);
    if (recipe.delta) subtract(filtered);
    text = filtered;
  }
  std::size_t size = 0;
  if (recipe.method == Method::kLz4) {
    size = static_cast<std::size_t>(LZ4_compress_fast_extState(libraries_->lz4.get(), chars(text),
                                                               chars(to), int_size(text.size()),
                                                               int_size(to.size()), 1));
  } else {
    size = ZSTD_compressCCtx(libraries_->compressing, to.data(), to.size(), text.data(),
                             text.size(), kZstdLevel);
    if (ZSTD_isError(size) != 0) return 0;
  }
  return from.size() > size * kRatioMax ? 0 : size;
}

bool Codec::decompress(const Recipe& recipe, std::span<const std::byte> from,
                       std::span<std::byte> to) {
  if (to.empty() || to.size() > kBlockMax || to.size() > from.size() * kRatioMax) return false;
  const bool filters = recipe.stride > 1 || recipe.delta;
  const std::span text = filters ? std::span(filtered_.get(), to.size()) : to;
  if (recipe.method == Method::kLz4) {
    const int size =
        LZ4_decompress_safe(chars(from), chars(text), int_size(from.size()), int_size(text.size()));
    if (size < 0 || static_cast<std::size_t>(size) != to.size()) return false;
  } else {
    const std::size_t size = ZSTD_decompressDCtx(libraries_->decompressing, text.data(),
                                                 text.size(), from.data(), from.size());
    if (ZSTD_isError(size) != 0 || size != to.size()) return false;
  }
  if (!filters) return true;
  if (recipe.delta) add_up(text);
  unshuffle(text, recipe.stride, to);
  return true;
}

}  // namespace tims::compression
