#include "tools/camera_calibrate/views.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::camera_calibrate {
namespace views_test {

using testing::HasSubstr;
using testing::IsEmpty;
using Verdict = ViewCollector::Verdict;

constexpr Board kBoard{.columns = 5, .rows = 4};
constexpr int kWidth = 600;
constexpr int kHeight = 400;

// `left`: length of the left edge, of a board whose right edge has `right`, around the middle.
std::vector<PicturePoint> board_at(double x, double y, double width, double left, double right) {
  std::vector<PicturePoint> points;
  for (int row = 0; row < kBoard.rows; ++row)
    for (int column = 0; column < kBoard.columns; ++column) {
      const double part = column / (kBoard.columns - 1.0);
      const double height = left + part * (right - left);
      points.push_back({static_cast<float>(x + (part - 0.5) * width),
                        static_cast<float>(y + (row / (kBoard.rows - 1.0) - 0.5) * height)});
    }
  return points;
}
std::vector<PicturePoint> turned(std::vector<PicturePoint> points) {
  for (PicturePoint& point : points) point = {point.y * 1.5F, point.x / 1.5F};
  return points;
}

TEST(Views, TheShapeIsPlaceSizeAndTilt) {
  const ViewShape flat = shape_of(board_at(150, 200, 120, 80, 80), kBoard, kWidth, kHeight);
  EXPECT_NEAR(flat.x, 0.25, 1e-6);
  EXPECT_NEAR(flat.y, 0.5, 1e-6);
  EXPECT_NEAR(flat.size, std::sqrt(120.0 * 80 / (600 * 400)), 1e-6);
  EXPECT_NEAR(flat.tilt_x, 0, 1e-6);
  EXPECT_NEAR(flat.tilt_y, 0, 1e-6);
  const ViewShape tilted = shape_of(board_at(150, 200, 120, 100, 80), kBoard, kWidth, kHeight);
  EXPECT_NEAR(tilted.tilt_x, std::log(100.0 / 80), 1e-6);
  // A board that is turned or held upside down is seen from the same side.
  auto upside_down = board_at(150, 200, 120, 100, 80);
  std::ranges::reverse(upside_down);
  EXPECT_NEAR(shape_of(upside_down, kBoard, kWidth, kHeight).tilt_x, std::log(100.0 / 80), 1e-6);
  const ViewShape on_its_side =
      shape_of(turned(board_at(150, 200, 120, 100, 80)), kBoard, kWidth, kHeight);
  EXPECT_NEAR(on_its_side.tilt_x, 0, 1e-6);
  EXPECT_NEAR(on_its_side.tilt_y, std::log(100.0 / 80), 1e-6);
  EXPECT_EQ(shape_of({}, kBoard, kWidth, kHeight).size, 0);  // not the board
}

TEST(Views, AViewIsTakenWhenTheBoardIsStillAndElsewhere) {
  ViewCollector views(kBoard, kWidth, kHeight);
  const auto here = board_at(150, 200, 120, 80, 80);
  EXPECT_EQ(views.offer(here, "a"), Verdict::kMoving);  // nothing to compare it with
  EXPECT_EQ(views.offer(here, "a"), Verdict::kTaken);
  EXPECT_EQ(views.offer(here, "b"), Verdict::kSimilar);
  const auto near = board_at(152.3, 200, 120, 80, 80);  // 2.3 of 2.4 pixels
  EXPECT_EQ(views.offer(near, "b"), Verdict::kSimilar);
  EXPECT_EQ(views.offer(board_at(155, 200, 120, 80, 80), "b"), Verdict::kMoving);
  const auto there = board_at(450, 200, 120, 80, 80);
  EXPECT_EQ(views.offer(there, "b"), Verdict::kMoving);
  views.offer_nothing();
  EXPECT_EQ(views.offer(there, "b"), Verdict::kMoving);
  EXPECT_EQ(views.offer(there, "b"), Verdict::kTaken);
  ASSERT_EQ(views.views().size(), 2U);
  EXPECT_EQ(views.views()[1].name, "b");
}

TEST(Views, StatesWhatIsMissing) {
  ViewCollector views(kBoard, kWidth, kHeight);
  EXPECT_EQ(views.missing().size(), kAreas * kAreas + 3U);
  // In all areas, but each area needs six points.
  views.take({.points = board_at(300, 200, 580, 390, 390)});
  EXPECT_THAT(views.missing(), testing::Contains("bring the board to the upper left"));
  EXPECT_THAT(views.missing(), testing::Not(testing::Contains(HasSubstr("nearer"))));
  for (const double x : {110, 300, 490})
    for (const double y : {70, 200, 330}) views.take({.points = board_at(x, y, 160, 100, 100)});
  EXPECT_THAT(views.missing(), testing::ElementsAre(HasSubstr("left or right edge"),
                                                    HasSubstr("upper or lower edge")));
  EXPECT_NEAR(covered_part(views.views(), kWidth, kHeight), 580 * 390 / (600.0 * 400), 1e-3);
  // Two views each, of either direction.
  views.take({.points = board_at(300, 200, 160, 100, 110)});
  EXPECT_EQ(views.missing().size(), 2U);
  views.take({.points = board_at(300, 200, 160, 110, 100)});
  EXPECT_THAT(views.missing(), testing::ElementsAre(HasSubstr("upper or lower edge")));
  for (int i = 0; i < 2; ++i) views.take({.points = turned(board_at(200, 200, 160, 110, 100))});
  EXPECT_THAT(views.missing(), IsEmpty());
}

TEST(Views, TheCornersOfThePictureMatter) {
  ViewCollector views(kBoard, kWidth, kHeight);
  const auto fill = [&](double part) {
    for (const double x : {-1, 0, 1})
      for (const double y : {-1, 0, 1})
        views.take({.points = board_at(300 + x * part * 200, 200 + y * part * 130, 120, 70, 80)});
  };
  fill(0.82);
  EXPECT_LT(covered_part(views.views(), kWidth, kHeight), kCoveredMin);
  EXPECT_THAT(views.missing(), testing::Contains(HasSubstr("farther into the corners")));
  fill(0.95);
  EXPECT_GT(covered_part(views.views(), kWidth, kHeight), kCoveredMin);
  EXPECT_THAT(views.missing(), testing::Not(testing::Contains(HasSubstr("corners"))));
  EXPECT_EQ(covered_part({}, kWidth, kHeight), 0);
}

}  // namespace views_test
}  // namespace rack::camera_calibrate
