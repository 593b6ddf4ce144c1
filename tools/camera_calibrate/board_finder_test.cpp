#include "tools/camera_calibrate/board_finder.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/rendered_board.h"

namespace rack::camera_calibrate {
namespace board_finder_test {

using tims::test::BoardPose;
using tims::test::RenderedCamera;

constexpr Board kChess{.columns = 9, .rows = 6, .square = 25};
constexpr Board kRound{.kind = BoardKind::kCircles, .columns = 8, .rows = 6, .square = 25};
constexpr BoardPose kPose{.x = 5, .y = -8, .z = 420, .turn_x = 0.3, .turn_y = -0.25, .turn_z = 0.1};

RenderedCamera camera_of(int width) {
  return RenderedCamera(
      {.width = width,
       .height = width * 3 / 4,
       .camera = {.fx = 0.8 * width, .fy = 0.8 * width, .cx = 0.5 * width, .cy = 0.375 * width},
       .distortion = {-0.2, 0.05, 0, 0, 0}},
      2);
}

GreyImage image_of(const RenderedCamera& camera, const Board& board, const BoardPose& pose,
                   const tims::test::PictureFaults& faults = {}) {
  return {.width = camera.calibration().width,
          .height = camera.calibration().height,
          .pixels = camera.render(board, pose, faults)};
}

// Boards are found from either end.
double error_of(std::vector<PicturePoint> found, const std::vector<PicturePoint>& seen) {
  const auto mean = [&] {
    double sum = 0;
    for (std::size_t i = 0; i < seen.size(); ++i)
      sum += std::hypot(found[i].x - seen[i].x, found[i].y - seen[i].y);
    return sum / static_cast<double>(seen.size());
  };
  const double forwards = mean();
  std::ranges::reverse(found);
  return std::min(forwards, mean());
}

TEST(BoardFinder, FindsPointsToATenthOfAPixel) {
  const RenderedCamera camera = camera_of(640);
  for (const Board& board : {kChess, kRound}) {
    const auto found = find_board(image_of(camera, board, kPose, {.noise = 4, .blur = 1}), board);
    ASSERT_TRUE(found) << name_of(board.kind);
    EXPECT_LT(error_of(*found, camera.seen(board, kPose)), 0.1) << name_of(board.kind);
  }
}

TEST(BoardFinder, LargePicturesAreSearchedSmallAndMeasuredLarge) {
  const RenderedCamera camera = camera_of(1360);
  const auto found = find_board(image_of(camera, kChess, kPose, {.blur = 1}), kChess);
  ASSERT_TRUE(found);
  EXPECT_LT(error_of(*found, camera.seen(kChess, kPose)), 0.1);
}

TEST(BoardFinder, FindsTheWholeBoardOnly) {
  const RenderedCamera camera = camera_of(320);
  const BoardPose beside{.x = 200, .y = 0, .z = 420};
  ASSERT_FALSE(camera.shows(kChess, beside));
  EXPECT_FALSE(find_board(image_of(camera, kChess, beside), kChess));
  EXPECT_FALSE(find_board(image_of(camera, kRound, beside), kRound));
  const BoardPose before{.x = 0, .y = 0, .z = 420};
  Board larger = kChess;
  larger.columns = 10;
  EXPECT_FALSE(find_board(image_of(camera, kChess, before), larger));
  EXPECT_TRUE(find_board(image_of(camera, kChess, before), kChess));
}

TEST(BoardFinder, AnyPictureMayBeSearched) {
  for (const auto& [width, height] :
       {std::pair(1, 1), std::pair(1, 300), std::pair(9, 6), std::pair(3000, 1), std::pair(64, 48)})
    for (const Board& board : {kChess, kRound}) {
      GreyImage image{.width = width, .height = height};
      image.pixels.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
      for (std::size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = static_cast<std::byte>(i * 2654435761U >> 13);
      EXPECT_FALSE(find_board(image, board)) << width << "x" << height;
    }
}

}  // namespace board_finder_test
}  // namespace rack::camera_calibrate
