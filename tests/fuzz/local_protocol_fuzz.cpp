// Each record has exactly one encoding: a decoded record is encoded to the same bytes.
#include "tests/fuzz/fuzz_input.h"
#include "wire/local_protocol.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tims;
  fuzz::Input input(data, size);
  const auto bytes = input.rest();
  const wire::Decoded decoded = wire::decode(bytes);
  fuzz::require(decoded.packet.has_value() == decoded.problem.empty());
  if (!decoded.packet) return 0;
  std::vector<std::byte> again;
  wire::encode(*decoded.packet, again);
  fuzz::require(std::ranges::equal(again, bytes));
  return 0;
}
