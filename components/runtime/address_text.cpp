#include "rack/address_text.h"

#include <array>

#include <fmt/format.h>

// A name of a class is one of people, of a few characters; a longer text is cut.
fmt::appender fmt::formatter<rack::AddressText>::format(const rack::AddressText& value,
                                                        fmt::format_context& context) const {
  std::array<char, 128> room{};
  const std::string_view text = value.address.write_to(room, value.widths);
  return fmt::formatter<fmt::string_view>::format(text, context);
}
