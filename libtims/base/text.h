// Text functions of all programs: UTF-8 and terminal output, quoting, hex digits, splitting of
// commands, and suggestions for misspelt names.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tims::base {

// --- characters

struct Character {
  std::uint32_t code = 0;
  std::size_t bytes = 0;  // length of the character; 0: the text does not begin with a valid one
};
// Strict: no overlong forms, no surrogates, no code points beyond Unicode. `text` is not empty.
Character first_character(std::string_view text);
void append_utf8(std::uint32_t code, std::string& out);
// C0 and C1 control characters, which a terminal executes.
constexpr bool is_control(std::uint32_t code) {
  return code < 0x20 || (code >= 0x7F && code < 0xA0);
}

// Invalid bytes become '?'.
std::string valid_utf8(std::string_view text);
// Text from another source for a terminal: control characters become '?' as well, so that a name
// cannot move the cursor.
std::string printable(std::string_view text);
// The same for texts with several lines.
std::string printable_lines(std::string_view text);
// Number of terminal columns, one for each character.
std::size_t display_width(std::string_view text);

// Converts ASCII letters to lower case; other characters are unchanged.
std::string lower(std::string_view text);

// --- quotes, digits, command lines

// A string literal of TOML or JSON: "a \"b\"\u000A". All control characters are escaped.
std::string in_quotes(std::string_view text);

// Parses a number; the whole text must be the number. A whole number may be given its radix.
template <typename Number, typename... Radix>
std::optional<Number> parse_number(std::string_view text, Radix... radix) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number, radix...);
  if (error != std::errc() || stop != end) return std::nullopt;
  return number;
}

// Without these characters at the beginning and end.
constexpr std::string_view trimmed(std::string_view text, std::string_view blanks = " \t\r") {
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  return text.substr(0, text.find_last_not_of(blanks) + 1);
}

std::string to_hex(std::span<const std::byte> bytes);
// Parses pairs of hex digits; blanks, line ends, ":" and "0x" may separate them.
std::optional<std::vector<std::byte>> parse_hex(std::string_view text);

// Splits "tims-demo ladar --at 'Ladar(1/0)'" as a shell does. Nothing: a quote is not closed.
std::optional<std::vector<std::string>> split_words(std::string_view text);

// --- placeholders: names in braces in the commands of a file, such as "{system}" for a robot's
// number. An opening brace without a closing one is ordinary text.

using Placeholders = std::map<std::string, std::string, std::less<>>;
// The first placeholder that is not known.
std::optional<std::string> unknown_placeholder(std::string_view text,
                                               std::span<const std::string> known);
// Replaces placeholders by their values; unknown ones are replaced by nothing.
std::string filled_in(std::string_view text, const Placeholders& values);

// --- suggestions for misspelt names
//
// The distance is the restricted Damerau-Levenshtein distance (optimal string alignment):
// insertions, deletions, replacements, and swaps of neighbours.

std::size_t edit_distance(std::string_view a, std::string_view b);
// Empty when no name is near enough: at most a third of the name may differ.
std::optional<std::string_view> nearest(std::string_view name,
                                        std::span<const std::string_view> known);
std::optional<std::string_view> nearest(std::string_view name, std::span<const std::string> known);

}  // namespace tims::base
