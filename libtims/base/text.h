// Texts as all programs here read and write them: UTF-8 and what of it may reach a terminal,
// quotes, hex digits, words, and the name somebody meant.
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
  std::size_t bytes = 0;  // it takes; 0: the text begins with none
};
// Strict: no forms that are too long, no halves of pairs, nothing beyond Unicode. `text` is not
// empty.
Character first_character(std::string_view text);
void append_utf8(std::uint32_t code, std::string& out);
// C0 and C1: what a terminal obeys.
constexpr bool is_control(std::uint32_t code) {
  return code < 0x20 || (code >= 0x7F && code < 0xA0);
}

// Broken bytes become '?'.
std::string valid_utf8(std::string_view text);
// Text of others on a terminal: control characters become '?' as well. A name must not move the
// cursor.
std::string printable(std::string_view text);
// The same for texts of several lines.
std::string printable_lines(std::string_view text);
// Columns the text takes on a terminal, one for each character.
std::size_t display_width(std::string_view text);

// Of ASCII letters; others stay.
std::string lower(std::string_view text);

// --- quotes, digits, words

// As a string of TOML or JSON: "a \"b\"\u000A". No control character is left, whatever a terminal
// obeys.
std::string in_quotes(std::string_view text);

// All of the text is this number; a whole one may be given its radix.
template <typename Number, typename... Radix>
std::optional<Number> parse_number(std::string_view text, Radix... radix) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number, radix...);
  if (error != std::errc() || stop != end) return std::nullopt;
  return number;
}

// Without these characters before and behind it.
constexpr std::string_view trimmed(std::string_view text, std::string_view blanks = " \t\r") {
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  return text.substr(0, text.find_last_not_of(blanks) + 1);
}

std::string to_hex(std::span<const std::byte> bytes);
// Pairs of digits; blanks, line ends, ":" and "0x" may stand between them.
std::optional<std::vector<std::byte>> parse_hex(std::string_view text);

// "tims-demo ladar --at 'Ladar(1/0)'" as a shell would cut it. Nothing: a quote is not closed.
std::optional<std::vector<std::string>> split_words(std::string_view text);

// --- placeholders: what may stand in braces in the commands of a file, as "{system}" for a robot's
// number. A brace that is opened and not closed is none of them.

using Placeholders = std::map<std::string, std::string, std::less<>>;
// The first one that is not known.
std::optional<std::string> unknown_placeholder(std::string_view text,
                                               std::span<const std::string> known);
// What is not known becomes nothing.
std::string filled_in(std::string_view text, const Placeholders& values);

// --- did you mean
//
// The distance is that of Damerau and Levenshtein in its restricted form: insertions, deletions,
// replacements and swaps of neighbours, none within another.

std::size_t edit_distance(std::string_view a, std::string_view b);
// Empty when nothing is near enough to be what somebody meant: a third of the name may differ.
std::optional<std::string_view> nearest(std::string_view name,
                                        std::span<const std::string_view> known);
std::optional<std::string_view> nearest(std::string_view name, std::span<const std::string> known);

}  // namespace tims::base
