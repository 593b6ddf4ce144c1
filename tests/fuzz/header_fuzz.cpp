// Any 16 bytes are a header; encoded again in the same byte order they are the same bytes.
#include <array>

#include "tests/fuzz/fuzz_input.h"
#include "wire/header.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tims;
  fuzz::Input input(data, size);
  const auto in = input.number<std::array<std::byte, kHeaderSize>>();
  const Header header = wire::decode_header(in);
  fuzz::use(wire::check_length(header.length, kMessageMaxDefault));

  std::array<std::byte, kHeaderSize> out{};
  const bool little = (header.flags & flag::kHeaderLittleEndian) != 0;
  wire::encode_header(header, out, little ? std::endian::little : std::endian::big);
  fuzz::require(out == in);

  wire::encode_header(header, out, little ? std::endian::big : std::endian::little);
  Header other = wire::decode_header(out);
  other.flags ^= flag::kHeaderLittleEndian;
  fuzz::require(other == header);
  return 0;
}
