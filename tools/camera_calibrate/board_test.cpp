#include "tools/camera_calibrate/board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::camera_calibrate {
namespace board_test {

using testing::HasSubstr;

std::string refusal(std::string_view kind, std::string_view size, double square) {
  const auto board = parse_board(kind, size, square);
  EXPECT_FALSE(board) << kind << " " << size << " " << square;
  return board ? "" : board.error().detail();
}

TEST(Board, IsParsed) {
  const auto board = parse_board("asymmetric-circles", "4x11", 18.5);
  ASSERT_TRUE(board);
  EXPECT_EQ(board->kind, BoardKind::kAsymmetricCircles);
  EXPECT_EQ(board->columns, 4);
  EXPECT_EQ(board->rows, 11);
  EXPECT_EQ(board->square, 18.5);
  EXPECT_EQ(board->points(), 44U);
  for (const BoardKind kind :
       {BoardKind::kChessboard, BoardKind::kCircles, BoardKind::kAsymmetricCircles})
    EXPECT_EQ(parse_board(name_of(kind), "3x50", 1)->kind, kind);
}

TEST(Board, RefusesWhatIsNone) {
  EXPECT_THAT(refusal("charuco", "9x6", 25), HasSubstr("asymmetric-circles, not charuco"));
  for (const char* size : {"", "9", "x", "9x", "x6", "2x6", "9x2", "51x6", "9x51", "9x6x3", "-9x6",
                           "9 x 6", "99999999999x6"})
    EXPECT_THAT(refusal("chessboard", size, 25), HasSubstr("--size must be COLUMNSxROWS"));
  for (const double square : {0.0, -1.0, 100001.0, std::nan("")})
    EXPECT_THAT(refusal("chessboard", "9x6", square), HasSubstr("--square"));
}

TEST(Board, PointsAreInRows) {
  const auto corners = positions({.columns = 3, .rows = 4, .square = 10});
  ASSERT_EQ(corners.size(), 12U);
  EXPECT_EQ(corners[5].x, 20);
  EXPECT_EQ(corners[5].y, 10);
  const auto circles =
      positions({.kind = BoardKind::kAsymmetricCircles, .columns = 3, .rows = 4, .square = 10});
  EXPECT_EQ(circles[2].x, 40);
  EXPECT_EQ(circles[3].x, 10);
  EXPECT_EQ(circles[3].y, 10);
}

}  // namespace board_test
}  // namespace rack::camera_calibrate
