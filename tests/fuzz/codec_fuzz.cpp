// Compressed messages from another router. Properties: no access is outside of the message or of
// the result, whose size is the announced one or nothing; what we compress ourselves is restored;
// a filter is undone exactly.
#include <algorithm>
#include <vector>

#include "router/link/packing.h"
#include "tests/fuzz/fuzz_input.h"
#include "wire/header.h"

namespace {

using namespace tims;

constexpr Address kLadar{0x03140000};
constexpr Address kPilot{0x03300000};

// Exactly as large as the bytes, so that a sanitizer sees any access outside.
core::Message message_of(std::vector<std::byte>& bytes) {
  const Header header{.type = type::kData,
                      .priority = 30,
                      .dest = kPilot,
                      .src = kLadar,
                      .length = static_cast<std::uint32_t>(bytes.size())};
  wire::encode_header(header, std::span(bytes).first<kHeaderSize>());
  return {.header = header, .bytes = bytes};
}

std::vector<std::byte> with_header(std::span<const std::byte> body) {
  std::vector<std::byte> bytes(kHeaderSize + body.size());
  std::ranges::copy(body, bytes.begin() + kHeaderSize);
  return bytes;
}

void check_foreign(link::Packing& packing, std::span<const std::byte> body) {
  std::vector<std::byte> bytes = with_header(body);
  core::Message message = message_of(bytes);
  message.packed = true;
  const auto size = packing.unpacked_size(message);
  if (!size) return;
  fuzz::require(*size > kHeaderSize && *size <= kHeaderSize + compression::kBlockMax);
  fuzz::require(*size - kHeaderSize <=
                (bytes.size() - link::Packing::kHeadSize) * compression::kRatioMax);
  std::vector<std::byte> to(*size);
  link::PackingCounters counters;
  const bool good = packing.unpack(message, to, counters);
  fuzz::require(counters.unpacked + counters.broken == 1);
  fuzz::require(!good || (!message.packed && message.header.length == *size));
}

void check_own(link::Packing& packing, compression::Method method,
               std::span<const std::byte> body) {
  std::vector<std::byte> bytes = with_header(body);
  const core::Message message = message_of(bytes);
  link::PackingCounters counters;
  auto packed = packing.pack(message, method, {}, counters);
  if (!packed) return;
  fuzz::require(packed->bytes.size() < bytes.size());
  fuzz::require(packing.unpacked_size(*packed) == bytes.size());
  std::vector<std::byte> back(bytes.size());
  fuzz::require(packing.unpack(*packed, back, counters) && back == bytes);
}

void check_filter(std::size_t stride, std::span<const std::byte> body) {
  std::vector<std::byte> filtered(body.size());
  std::vector<std::byte> back(body.size());
  compression::shuffle(body, stride % (compression::kStrideMax + 1), filtered);
  compression::subtract(filtered);
  compression::add_up(filtered);
  compression::unshuffle(filtered, stride % (compression::kStrideMax + 1), back);
  fuzz::require(std::ranges::equal(back, body));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  link::Packing packing({}, {});
  const auto body = std::as_bytes(std::span(data, size)).subspan(2);
  check_foreign(packing, body);
  check_own(packing, data[0] % 2 == 0 ? compression::Method::kLz4 : compression::Method::kZstd,
            body);
  check_filter(data[1], body);
  return 0;
}
