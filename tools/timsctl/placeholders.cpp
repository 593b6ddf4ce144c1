#include "tools/timsctl/placeholders.h"

#include <algorithm>

namespace timsctl {

namespace {

// What stands before the next braces, and in them; `text` is left with what stands behind them.
struct Piece {
  std::string_view before;
  std::optional<std::string_view> name;  // none: there were no more
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

}  // namespace timsctl
