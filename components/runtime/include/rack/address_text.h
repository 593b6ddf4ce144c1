// An address in a log text: "{}" prints its name, as "Ladar(3/0)".
#pragma once

#include <fmt/core.h>

#include "tims/address.h"

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

// An address alone cannot be printed: its text depends on the widths of its fleet. TextLog adds
// them.
struct AddressText {
  tims::Address address;
  tims::AddressWidths widths;
};

}  // namespace rack

namespace fmt {

// Fill, width and precision as for texts: "{:<20}". Allocates nothing.
template <>
struct formatter<rack::AddressText> : formatter<string_view> {
  appender format(const rack::AddressText& value, format_context& context) const;
};

}  // namespace fmt

#pragma GCC visibility pop
