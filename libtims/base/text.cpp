#include "base/text.h"

#include <algorithm>
#include <array>

namespace tims::base {
namespace {

constexpr std::string_view kDigits = "0123456789abcdef";

template <typename Names>
std::optional<std::string_view> nearest_of(std::string_view name, const Names& known) {
  std::optional<std::string_view> best;
  std::size_t best_distance = std::max<std::size_t>(1, name.size() / 3) + 1;
  for (const std::string_view candidate : known) {
    const std::size_t distance = edit_distance(name, candidate);
    if (distance >= best_distance) continue;
    best = candidate;
    best_distance = distance;
  }
  return best;
}

// Copies every character; invalid bytes and characters selected by `hide` become '?'.
template <typename Hide>
std::string with_question_marks(std::string_view text, Hide hide) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const Character c = first_character(text);
    if (c.bytes == 0 || hide(c.code)) {
      out += '?';
    } else {
      out += text.substr(0, c.bytes);
    }
    text.remove_prefix(std::max<std::size_t>(c.bytes, 1));
  }
  return out;
}

// The text before the next pair of braces, and the name in them; `text` becomes the remainder.
struct Piece {
  std::string_view before;
  std::optional<std::string_view> name;  // none: there are no more braces
};
Piece next_piece(std::string_view& text) {
  const std::size_t open = text.find('{');
  const std::size_t close = open == std::string_view::npos ? open : text.find('}', open);
  if (close == std::string_view::npos) return {.before = text, .name = {}};
  const Piece piece{.before = text.substr(0, open),
                    .name = text.substr(open + 1, close - open - 1)};
  text.remove_prefix(close + 1);
  return piece;
}

}  // namespace

Character first_character(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(text[i]) & 0xFF; };
  const std::uint32_t first = byte(0);
  if (first < 0x80) return {first, 1};
  const std::size_t bytes = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4 || bytes > text.size()) return {};
  std::uint32_t code = first & (0x7FU >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if (byte(i) >> 6 != 2) return {};
    code = code << 6 | (byte(i) & 0x3F);
  }
  constexpr std::array<std::uint32_t, 5> kSmallest = {0, 0, 0x80, 0x800, 0x10000};
  const bool half_of_a_pair = code >= 0xD800 && code < 0xE000;
  if (code < kSmallest.at(bytes) || half_of_a_pair || code > 0x10FFFF) return {};
  return {code, bytes};
}

void append_utf8(std::uint32_t code, std::string& out) {
  const auto put = [&out](std::uint32_t byte) { out += static_cast<char>(byte); };
  if (code < 0x80) return put(code);
  if (code < 0x800) {
    put(0xC0 | code >> 6);
  } else if (code < 0x10000) {
    put(0xE0 | code >> 12);
    put(0x80 | (code >> 6 & 0x3F));
  } else {
    put(0xF0 | code >> 18);
    put(0x80 | (code >> 12 & 0x3F));
    put(0x80 | (code >> 6 & 0x3F));
  }
  put(0x80 | (code & 0x3F));
}

std::string valid_utf8(std::string_view text) {
  return with_question_marks(text, [](std::uint32_t) { return false; });
}

std::string printable(std::string_view text) { return with_question_marks(text, is_control); }

std::string printable_lines(std::string_view text) {
  return with_question_marks(text,
                             [](std::uint32_t code) { return code != '\n' && is_control(code); });
}

std::size_t display_width(std::string_view text) {
  const auto begins = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; };
  return static_cast<std::size_t>(std::ranges::count_if(text, begins));
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c | 0x20);
  return out;
}

std::string in_quotes(std::string_view text) {
  constexpr std::string_view kUpperDigits = "0123456789ABCDEF";
  std::string out(1, '"');
  while (!text.empty()) {
    const Character c = first_character(text);
    const std::size_t bytes = std::max<std::size_t>(c.bytes, 1);
    if (c.code == '"' || c.code == '\\') out += '\\';
    if (c.bytes > 0 && is_control(c.code)) {
      out.append("\\u00").append({kUpperDigits[c.code >> 4], kUpperDigits[c.code & 0xF]});
    } else {
      out += text.substr(0, bytes);
    }
    text.remove_prefix(bytes);
  }
  out += '"';
  return out;
}

std::string to_hex(std::span<const std::byte> bytes) {
  std::string text;
  text.reserve(2 * bytes.size());
  for (const std::byte b : bytes) {
    text += kDigits[std::to_integer<unsigned>(b) >> 4];
    text += kDigits[std::to_integer<unsigned>(b) & 0xF];
  }
  return text;
}

std::optional<std::vector<std::byte>> parse_hex(std::string_view text) {
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 2);
  while (!text.empty()) {
    if (text.starts_with(' ') || text.starts_with(':') || text.starts_with('\n')) {
      text.remove_prefix(1);
      continue;
    }
    if (text.starts_with("0x")) text.remove_prefix(2);
    if (text.size() < 2) return std::nullopt;
    const auto value = parse_number<std::uint8_t>(text.substr(0, 2), 16);
    if (!value) return std::nullopt;
    bytes.push_back(static_cast<std::byte>(*value));
    text.remove_prefix(2);
  }
  return bytes;
}

std::optional<std::vector<std::string>> split_words(std::string_view text) {
  std::vector<std::string> words;
  std::string word;
  bool in_word = false;
  char quote = 0;
  for (const char c : text) {
    if (quote != 0 && c == quote) {
      quote = 0;
    } else if (quote != 0) {
      word += c;
    } else if (c == '\'' || c == '"') {
      quote = c;
      in_word = true;
    } else if (c == ' ' || c == '\t' || c == '\n') {
      if (in_word) words.push_back(std::move(word));
      word.clear();
      in_word = false;
    } else {
      word += c;
      in_word = true;
    }
  }
  if (quote != 0) return std::nullopt;
  if (in_word) words.push_back(std::move(word));
  return words;
}

std::optional<std::string> unknown_placeholder(std::string_view text,
                                               std::span<const std::string> known) {
  while (const auto name = next_piece(text).name)
    if (std::ranges::find(known, *name) == known.end()) return std::string(*name);
  return std::nullopt;
}

std::string filled_in(std::string_view text, const Placeholders& values) {
  std::string out;
  for (;;) {
    const Piece piece = next_piece(text);
    out += piece.before;
    if (!piece.name) return out;
    const auto value = values.find(*piece.name);
    if (value != values.end()) out += value->second;
  }
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  // Three rows of the usual distance table, because a swap refers to the row before the last.
  std::vector<std::size_t> before_last(b.size() + 1);
  std::vector<std::size_t> last(b.size() + 1);
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before_last.swap(last);
    last.swap(row);
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({replaced, last[j] + 1, row[j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
  }
  return row[b.size()];
}

std::optional<std::string_view> nearest(std::string_view name,
                                        std::span<const std::string_view> known) {
  return nearest_of(name, known);
}

std::optional<std::string_view> nearest(std::string_view name, std::span<const std::string> known) {
  return nearest_of(name, known);
}

}  // namespace tims::base
