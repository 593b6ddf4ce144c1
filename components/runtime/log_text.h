// A log text as the body of its message.
#pragma once

#include <cstddef>

#include <fmt/core.h>

#include "rack/proxies/gdos.h"

namespace rack {

// Formats the text into `body` and returns its length. Allocates nothing. A format whose arguments
// are wrong (a negative width that is an argument itself; the compiler finds all else) is sent as
// it is, because logging must never stop a component.
std::size_t log_text(gdos::Body& body, fmt::string_view format, fmt::format_args arguments);

}  // namespace rack
