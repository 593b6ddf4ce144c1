// Compressing and decompressing does not allocate, neither here nor in the libraries.
#include <vector>

#include <gtest/gtest.h>
#include <malloc.h>

#include "router/compression/codec.h"
#include "router/compression/sample_bytes.h"
#include "tests/support/counted_new.h"

namespace tims::compression {
namespace codec_allocation_test {

std::size_t bytes_of_malloc() { return mallinfo2().uordblks; }

TEST(NoAllocation, CompressingAMessage) {
  Codec codec;
  const std::vector<std::byte> from = scan_like(kBlockMax);
  std::vector<std::byte> packed(kBlockMax);
  std::vector<std::byte> back(kBlockMax);
  const std::size_t before = test::allocations();
  const std::size_t bytes_before = bytes_of_malloc();
  ASSERT_GT(before, 0U) << "it counts";
  for (const Method method : {Method::kLz4, Method::kZstd}) {
    // Sizes go up and down, and small ones come so often that zstd would give memory back.
    for (int i = 0; i < 400; ++i) {
      const std::size_t size = i % 200 == 0 ? kBlockMax : 600 + static_cast<std::size_t>(i) * 13;
      const Recipe recipe = recipe_for(method, 16);
      const std::size_t used = codec.compress(recipe, std::span(from).first(size), packed);
      ASSERT_GT(used, 0U);
      ASSERT_TRUE(
          codec.decompress(recipe, std::span(packed).first(used), std::span(back).first(size)));
      ASSERT_EQ(bytes_of_malloc(), bytes_before);
    }
  }
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace codec_allocation_test
}  // namespace tims::compression
