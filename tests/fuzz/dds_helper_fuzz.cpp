// Records of a DDS helper that an attacker has taken over, or of a router to it. Property: no
// access is outside of the record; a decoded one is the same after encoding and decoding again.
#include <algorithm>
#include <array>
#include <memory>

#include "router/io/dds/helper_protocol.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tims;
  using namespace tims::io;
  // Exactly as large as the bytes, so that a sanitizer sees any access outside.
  const auto bytes = std::make_unique<std::byte[]>(size);
  std::ranges::copy(std::as_bytes(std::span(data, size)), bytes.get());
  const auto record = helper::decode({bytes.get(), size});
  if (!record) return 0;
  const auto once = std::make_unique<std::array<std::byte, helper::kRecordMax>>();
  const auto twice = std::make_unique<std::array<std::byte, helper::kRecordMax>>();
  const std::size_t length = helper::encode(*record, *once);
  if (length == 0) return 0;
  const auto again = helper::decode(std::span(*once).first(length));
  fuzz::require(again && again->index() == record->index());
  fuzz::require(helper::encode(*again, *twice) == length);
  fuzz::require(
      std::ranges::equal(std::span(*once).first(length), std::span(*twice).first(length)));
  return 0;
}
