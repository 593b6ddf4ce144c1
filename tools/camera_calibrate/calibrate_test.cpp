#include "tools/camera_calibrate/calibrate.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/rendered_board.h"
#include "tools/camera_calibrate/board_finder.h"

namespace rack::camera_calibrate {
namespace calibrate_test {

using testing::HasSubstr;
using testing::IsEmpty;
using tims::test::BoardPose;
using tims::test::RenderedCamera;

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr Board kBoard{.kind = BoardKind::kChessboard, .columns = 9, .rows = 6, .square = 25};

pictures::CameraCalibration lens() {
  return {.width = kWidth,
          .height = kHeight,
          .camera = {.fx = 520, .fy = 515, .cx = 331, .cy = 226},
          .distortion = {-0.28, 0.09, 0.001, -0.0007, 0}};
}

const RenderedCamera& camera() {
  static const RenderedCamera the_camera(lens(), 2);
  return the_camera;
}

std::vector<View> rendered(const Board& board, std::size_t count, double tilt,
                           const tims::test::PictureFaults& faults) {
  std::vector<View> views;
  for (const BoardPose& pose : camera().poses(board, count, tilt)) {
    auto one = faults;
    one.seed = static_cast<std::uint32_t>(views.size() + 1);
    const GreyImage image{
        .width = kWidth, .height = kHeight, .pixels = camera().render(board, pose, one)};
    auto points = find_board(image, board);
    EXPECT_TRUE(points) << "view " << views.size();
    if (points)
      views.push_back(
          {.name = "view " + std::to_string(views.size() + 1), .points = std::move(*points)});
  }
  return views;
}

struct Tolerance {
  double focal;   // part
  double centre;  // pixels
  double k1;
  double k2;
  double error;  // pixels
};

void expect_lens(const Calibrated& made, const Tolerance& tolerance) {
  const auto truth = lens();
  const auto& found = made.calibration;
  EXPECT_NEAR(found.camera.fx, truth.camera.fx, tolerance.focal * truth.camera.fx);
  EXPECT_NEAR(found.camera.fy, truth.camera.fy, tolerance.focal * truth.camera.fy);
  EXPECT_NEAR(found.camera.cx, truth.camera.cx, tolerance.centre);
  EXPECT_NEAR(found.camera.cy, truth.camera.cy, tolerance.centre);
  EXPECT_NEAR(found.distortion.at(0), truth.distortion.at(0), tolerance.k1);
  EXPECT_NEAR(found.distortion.at(1), truth.distortion.at(1), tolerance.k2);
  EXPECT_LT(made.error, tolerance.error);
}

TEST(Calibrate, FindsTheLensByAChessboard) {
  const auto views = rendered(kBoard, 18, 0.6, {.noise = 3, .blur = 1});
  const auto made = calibrate(views, kBoard, kWidth, kHeight);
  ASSERT_TRUE(made) << made.error().detail();
  expect_lens(*made, {.focal = 0.0015, .centre = 1, .k1 = 0.005, .k2 = 0.01, .error = 0.12});
  EXPECT_THAT(made->warnings, IsEmpty());
  EXPECT_EQ(made->views.size(), views.size());
  EXPECT_EQ(made->calibration.width, kWidth);
}

// Circles are found by their centres in the picture, which are not exactly the pictures of their
// centres.
TEST(Calibrate, FindsTheLensByCircles) {
  for (const Board& board :
       {Board{.kind = BoardKind::kCircles, .columns = 8, .rows = 6, .square = 25},
        Board{.kind = BoardKind::kAsymmetricCircles, .columns = 4, .rows = 11, .square = 15}}) {
    SCOPED_TRACE(name_of(board.kind));
    const auto views = rendered(board, 18, 0.5, {.noise = 3, .blur = 1});
    const auto made = calibrate(views, board, kWidth, kHeight);
    ASSERT_TRUE(made) << made.error().detail();
    expect_lens(*made, {.focal = 0.001, .centre = 0.5, .k1 = 0.003, .k2 = 0.01, .error = 0.05});
  }
}

// Points as they are found, without pictures.
std::vector<View> seen(const std::vector<BoardPose>& poses, double noise = 0.05) {
  std::mt19937 random(7);
  std::normal_distribution<float> error(0, static_cast<float>(noise));
  std::vector<View> views;
  for (const BoardPose& pose : poses) {
    View view{.name = "view " + std::to_string(views.size() + 1),
              .points = camera().seen(kBoard, pose)};
    for (PicturePoint& point : view.points) {
      point.x += error(random);
      point.y += error(random);
    }
    views.push_back(std::move(view));
  }
  return views;
}

std::string refusal(const std::vector<View>& views) {
  const auto made = calibrate(views, kBoard, kWidth, kHeight);
  EXPECT_FALSE(made);
  if (made) return {};
  EXPECT_EQ(made.error().code(), tims::Errc::kInvalidArgument);
  return made.error().detail();
}

TEST(Calibrate, NeedsSixViews) {
  const auto poses = camera().poses(kBoard, 6, 0.6);
  auto views = seen(poses);
  const auto made = calibrate(views, kBoard, kWidth, kHeight);
  ASSERT_TRUE(made) << made.error().detail();
  EXPECT_THAT(made->warnings, testing::Contains(HasSubstr("only 6 views")));
  views.pop_back();
  EXPECT_THAT(refusal(views), HasSubstr("5 views of the board; at least 6 are needed"));
  EXPECT_THAT(refusal({}), HasSubstr("0 views"));
  views.resize(kCalibrationViewsMax + 1, views.front());
  EXPECT_THAT(refusal(views), HasSubstr("at most 500"));
}

TEST(Calibrate, RefusesABoardThatWasNeverTilted) {
  EXPECT_THAT(refusal(seen(camera().poses(kBoard, 20, 0))), HasSubstr("Tilt the board"));
  EXPECT_THAT(refusal(seen(std::vector(20, camera().poses(kBoard, 1, 0.6).front()))),
              HasSubstr("Tilt the board"));
  // Below and above the limit of 10 degrees between two views.
  EXPECT_THAT(refusal(seen(camera().poses(kBoard, 20, 0.05))), HasSubstr("same direction"));
  EXPECT_TRUE(calibrate(seen(camera().poses(kBoard, 20, 0.2)), kBoard, kWidth, kHeight));
}

TEST(Calibrate, RefusesPicturesOfAnotherBoard) {
  EXPECT_THAT(refusal(seen(camera().poses(kBoard, 20, 0.6), 25)), HasSubstr("residuals are"));
}

TEST(Calibrate, WarnsOfTheViewThatIsOff) {
  auto views = seen(camera().poses(kBoard, 20, 0.6));
  std::mt19937 random(3);
  std::normal_distribution<float> shaken(0, 1);
  for (PicturePoint& point : views[4].points) point.x += shaken(random);
  const auto made = calibrate(views, kBoard, kWidth, kHeight);
  ASSERT_TRUE(made) << made.error().detail();
  ASSERT_THAT(made->warnings, testing::SizeIs(1));
  EXPECT_THAT(made->warnings[0], testing::StartsWith("view 5: "));
  for (std::size_t i = 0; i < made->views.size(); ++i)
    EXPECT_EQ(made->views[i].is_outlier, i == 4) << i;
}

TEST(Calibrate, WarnsOfPartsOfThePictureWithoutBoard) {
  std::vector<BoardPose> poses;
  for (const BoardPose& pose : camera().poses(kBoard, 20, 0.6))
    poses.push_back({.x = 0, .y = 0, .z = 900, .turn_x = pose.turn_x, .turn_y = pose.turn_y});
  const auto made = calibrate(seen(poses), kBoard, kWidth, kHeight);
  ASSERT_TRUE(made) << made.error().detail();
  EXPECT_LT(made->covered, 0.2);
  EXPECT_THAT(made->warnings, testing::Contains(HasSubstr("in the corners")));
}

TEST(Calibrate, ResidualsAreThoseOfTheError) {
  const auto made = calibrate(seen(camera().poses(kBoard, 20, 0.6)), kBoard, kWidth, kHeight);
  ASSERT_TRUE(made);
  double squares = 0;
  for (const CalibratedView& view : made->views) {
    EXPECT_EQ(view.residuals.size(), kBoard.points());
    squares += view.error * view.error;
  }
  EXPECT_NEAR(std::sqrt(squares / 20), made->error, 1e-4);
  EXPECT_NEAR(made->error, 0.05 * std::sqrt(2), 0.01);
}

// keep: pictures are enlarged until there is no border, or all of the camera's picture is kept.
TEST(Calibrate, RectifiedPicturesKeepWhatIsAskedFor) {
  const auto views = seen(camera().poses(kBoard, 20, 0.6));
  const auto without = calibrate(views, kBoard, kWidth, kHeight, {.keep = 0});
  const auto with_all = calibrate(views, kBoard, kWidth, kHeight, {.keep = 1});
  ASSERT_TRUE(without && with_all);
  EXPECT_GT(without->calibration.rectified.fx, 1.05 * with_all->calibration.rectified.fx);
  EXPECT_EQ(without->calibration.distortion.at(4), 0);
  EXPECT_NE(calibrate(views, kBoard, kWidth, kHeight, {.has_k3 = true})->calibration.distortion[4],
            0);
}

}  // namespace calibrate_test
}  // namespace rack::camera_calibrate
