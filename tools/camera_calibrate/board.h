// The board that a camera is shown: a chessboard or a grid of circles. Its points are the inner
// corners of the chessboard, or the centres of the circles. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tims/result.h"

namespace rack::camera_calibrate {

enum class BoardKind : std::uint8_t { kChessboard, kCircles, kAsymmetricCircles };

struct Board {
  BoardKind kind = BoardKind::kChessboard;
  int columns = 9;  // points in a row
  int rows = 6;
  double square = 25;  // mm; see BoardPosition

  [[nodiscard]] std::size_t points() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  }
};

inline constexpr int kBoardSideMin = 3;
inline constexpr int kBoardSideMax = 50;

// A point in a picture, pixels.
struct PicturePoint {
  float x = 0;
  float y = 0;
};

// A point on the board, mm. Points are `square` apart; those of asymmetric circles are 2 * square
// apart in a row, the rows are `square` apart, and every second row is displaced by `square`.
struct BoardPosition {
  double x = 0;
  double y = 0;
};

// "chessboard", "circles", "asymmetric-circles", and "9x6". kInvalidArgument: what is wrong, and
// what to write instead.
tims::Result<Board> parse_board(std::string_view kind, std::string_view size, double square);
std::string_view name_of(BoardKind kind);

// Row by row.
std::vector<BoardPosition> positions(const Board& board);

}  // namespace rack::camera_calibrate
