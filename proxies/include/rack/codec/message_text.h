// Bodies of any message as text and from text: JSON, lines for human readers, lines of numbers as
// in recordings, and assignments "field=value".
#pragma once

#include <bit>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rack/codec/schema.h"
#include "tims/address.h"
#include "tims/result.h"

#pragma GCC visibility push(default)  // exported by librack.so
namespace rack {

inline constexpr std::size_t kAllElements = std::numeric_limits<std::size_t>::max();

struct PrintStyle {
  std::size_t elements_max = kAllElements;  // of a sequence: only the first ones are written
  bool si = false;                          // numbers in SI units
  bool one_line = false;                    // text on one line: "pos.x 100 mm, pos.y 0 mm"
  tims::AddressWidths widths{};
};

// --- output

// One line of JSON. Counts are written like other fields. Addresses and texts are strings, bytes
// are strings of hex digits; numbers that are not finite and the address kNobody are null.
std::string to_json(const Schema& schema, const MessageValue& value, const PrintStyle& style = {});
// One line for each number ("pos.x: 100 mm") and for each element of a sequence.
std::string to_text(const Schema& schema, const MessageValue& value, const PrintStyle& style = {});
// All numbers, separated by blanks, as in recordings (specification, section 11); texts in quotes.
std::string to_numbers(const Schema& schema, const MessageValue& value);
// A received body; kMalformed.
Result<std::string> body_json(const Schema& schema, std::span<const std::byte> body,
                              std::endian order, const PrintStyle& style = {});
Result<std::string> body_text(const Schema& schema, std::span<const std::byte> body,
                              std::endian order, const PrintStyle& style = {});

// --- input

// A field, "pos.x", and its new value: "100", or with the unit of the wire or of SI: "100mm",
// "0.1m".
struct Assignment {
  std::string_view field;
  std::string_view value;
};
// Sets one number, text or address. Numbers without a unit are in the unit of the wire, or with
// style.si in SI units. The elements of a sequence are set in their order: the index after the last
// element appends one. On failure: kInvalidArgument, and nothing is changed.
Result<void> assign(const Schema& schema, MessageValue& value, const Assignment& assignment,
                    const PrintStyle& style = {});
// The body of a message with the given fields; the others have the defaults of its struct.
Result<std::vector<std::byte>> make_body(const Schema& schema, std::span<const Assignment> set,
                                         std::endian order, const PrintStyle& style);

// --- columns

// A number of a message, with the name that to_text() prints.
struct Column {
  std::string name;          // "pos.x"; of the elements of a sequence "points[].angle"
  std::string_view unit;     // "mm"; empty: none
  std::string_view si_unit;  // "m"
  std::string_view type;     // "i32", "f32", "address", "text"; "count": size of the next sequence
  bool operator==(const Column&) const = default;
};
// In the order of the wire; the fields of inner structs are listed individually.
std::vector<Column> columns_of(const Schema& schema);

// In quotes. Everything except printable ASCII is escaped, because the character set is not known.
void append_quoted(std::string& out, std::string_view text);

}  // namespace rack

#pragma GCC visibility pop
