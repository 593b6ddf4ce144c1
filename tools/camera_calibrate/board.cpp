#include "tools/camera_calibrate/board.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/core.h>

#include "base/text.h"

namespace rack::camera_calibrate {
namespace {

using tims::Errc;
using tims::Error;

struct NamedKind {
  std::string_view name;
  BoardKind kind;
};
constexpr std::array<NamedKind, 3> kKinds = {{
    {"chessboard", BoardKind::kChessboard},
    {"circles", BoardKind::kCircles},
    {"asymmetric-circles", BoardKind::kAsymmetricCircles},
}};

std::optional<std::pair<int, int>> parse_size(std::string_view text) {
  const std::size_t x = text.find('x');
  if (x == std::string_view::npos) return std::nullopt;
  const auto columns = tims::base::parse_number<int>(text.substr(0, x));
  const auto rows = tims::base::parse_number<int>(text.substr(x + 1));
  const auto is_side = [](int side) { return side >= kBoardSideMin && side <= kBoardSideMax; };
  if (!columns || !rows || !is_side(*columns) || !is_side(*rows)) return std::nullopt;
  return std::pair(*columns, *rows);
}

}  // namespace

std::string_view name_of(BoardKind kind) { return kKinds.at(static_cast<std::size_t>(kind)).name; }

tims::Result<Board> parse_board(std::string_view kind, std::string_view size, double square) {
  const auto* const named = std::ranges::find(kKinds, kind, &NamedKind::name);
  if (named == kKinds.end())
    return Error(
        Errc::kInvalidArgument,
        fmt::format("--board must be chessboard, circles or asymmetric-circles, not {}", kind));
  const auto sides = parse_size(size);
  if (!sides)
    return Error(Errc::kInvalidArgument,
                 fmt::format("--size must be COLUMNSxROWS, {} to {} each, for example 9x6, not {}: "
                             "count the inner corners of a chessboard, or the circles",
                             kBoardSideMin, kBoardSideMax, size));
  if (!(square > 0) || square > 1e5)
    return Error(Errc::kInvalidArgument, "--square must be more than 0 and at most 100000 mm");
  return Board{
      .kind = named->kind, .columns = sides->first, .rows = sides->second, .square = square};
}

std::vector<BoardPosition> positions(const Board& board) {
  std::vector<BoardPosition> all;
  const bool is_asymmetric = board.kind == BoardKind::kAsymmetricCircles;
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      all.push_back({.x = board.square * (is_asymmetric ? 2 * column + row % 2 : column),
                     .y = board.square * row});
  return all;
}

}  // namespace rack::camera_calibrate
