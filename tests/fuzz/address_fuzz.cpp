// A parsed address is printed in a form that can be parsed, with every width; a parsed pattern can
// be matched with every address.
#include "tests/fuzz/fuzz_input.h"
#include "tims/address.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tims;
  fuzz::Input input(data, size);
  AddressWidths widths{.system = input.number<std::uint8_t>(),
                       .class_id = input.number<std::uint8_t>(),
                       .instance = input.number<std::uint8_t>(),
                       .local = input.number<std::uint8_t>()};
  if (!widths.valid()) widths = {};
  const Address raw(input.number<std::uint32_t>());
  fuzz::require(Address::parse(raw.to_string(widths), widths) == raw);
  fuzz::require(Address::parse(raw.to_hex(), widths) == raw);
  fuzz::require(Address::of(raw.fields(widths), widths) == raw);

  const std::string_view text = input.text();
  const auto address = Address::parse(text, widths);
  if (address) fuzz::require(Address::parse(address->to_string(widths), widths) == address);
  const auto pattern = AddressPattern::parse(text, widths);
  fuzz::use(pattern && pattern->matches(raw));
  if (pattern) fuzz::require(Address::problem(text, widths).empty());
  // The text of an address is also a pattern that matches this address.
  if (address) fuzz::require(pattern && pattern->matches(*address));
  return 0;
}
