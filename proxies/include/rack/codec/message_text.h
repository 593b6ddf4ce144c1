// Bodies of any message as text, and out of it: JSON, lines for people, lines of numbers as in
// recordings, and "field=value" as people write it.
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

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

inline constexpr std::size_t kAllElements = std::numeric_limits<std::size_t>::max();

struct PrintStyle {
  std::size_t elements_max = kAllElements;  // of a sequence, the first ones
  bool si = false;                          // numbers in SI units
  bool one_line = false;                    // of text: "pos.x 100 mm, pos.y 0 mm"
  tims::AddressWidths widths{};
};

// --- told

// One line of JSON. Counts are told like other fields. Addresses and texts are strings, bytes are
// strings of hex digits; numbers that are not finite, and an address that is nobody's, are null.
std::string to_json(const Schema& schema, const MessageValue& value, const PrintStyle& style = {});
// One line a number ("pos.x: 100 mm"), and one for each element of a sequence.
std::string to_text(const Schema& schema, const MessageValue& value, const PrintStyle& style = {});
// All numbers, separated by blanks, as recordings have them (specification, section 11); texts in
// quotes.
std::string to_numbers(const Schema& schema, const MessageValue& value);
// A body as it came; kMalformed.
Result<std::string> body_json(const Schema& schema, std::span<const std::byte> body,
                              std::endian order, const PrintStyle& style = {});
Result<std::string> body_text(const Schema& schema, std::span<const std::byte> body,
                              std::endian order, const PrintStyle& style = {});

// --- made

// "pos.x" and what it shall be: "100", and with the unit of the wire or SI: "100mm", "0.1m".
struct Assignment {
  std::string_view field;
  std::string_view value;
};
// Sets one number, text or address. Numbers without a unit are those of the wire, or with style.si
// in SI units. The elements of a sequence are set in their order: one behind the last makes it
// longer. Fails with kInvalidArgument, and changes nothing then.
Result<void> assign(const Schema& schema, MessageValue& value, const Assignment& assignment,
                    const PrintStyle& style = {});
// The body of a message made of fields by name, the others as its struct has them.
Result<std::vector<std::byte>> make_body(const Schema& schema, std::span<const Assignment> set,
                                         std::endian order, const PrintStyle& style);

// ---

// A number of a message, by the name that to_text() gives it.
struct Column {
  std::string name;          // "pos.x"; of the elements of a sequence "points[].angle"
  std::string_view unit;     // "mm"; empty: none
  std::string_view si_unit;  // "m"
  std::string_view type;     // "i32", "f32", "address", "text"; "count": of the sequence behind it
  bool operator==(const Column&) const = default;
};
// In the order of the wire, with the fields of inner structs one by one.
std::vector<Column> columns_of(const Schema& schema);

// In quotes. What is no printable ASCII is escaped: nobody knows the character set.
void append_quoted(std::string& out, std::string_view text);

}  // namespace rack

#pragma GCC visibility pop
