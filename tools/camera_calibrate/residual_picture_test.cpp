#include "tools/camera_calibrate/residual_picture.h"

#include <gtest/gtest.h>

#include "tools/camera_calibrate/grey_image.h"

namespace rack::camera_calibrate {
namespace residual_picture_test {

Calibrated made_with(int views, double length) {
  Calibrated made;
  made.calibration = {.width = 640,
                      .height = 480,
                      .camera = {.fx = 500, .fy = 500, .cx = 320, .cy = 240},
                      .distortion = {0, 0, 0, 0, 0}};
  for (int i = 0; i < views; ++i) {
    CalibratedView view{.name = "view", .error = length, .is_outlier = i == 0};
    view.residuals = {{.at = {10, 10}, .x = length, .y = -length},
                      {.at = {600, 400}, .x = -length, .y = 0}};
    made.views.push_back(view);
  }
  made.error = length;
  return made;
}

GreyImage drawn(const Calibrated& made) {
  const auto png = draw_residuals(made);
  EXPECT_TRUE(png);
  const auto image = grey_of_file(png ? *png : "");
  EXPECT_TRUE(image);
  return image ? *image : GreyImage{};
}

TEST(ResidualPicture, IsDrawnForAnyResiduals) {
  const GreyImage usual = drawn(made_with(20, 0.1));
  EXPECT_GT(usual.width, 1000);
  EXPECT_GT(usual.height, 900);
  for (const double length : {0.0, 1e-12, 1000.0, 1e12})
    EXPECT_EQ(drawn(made_with(1, length)).width, usual.width) << length;
  EXPECT_EQ(drawn(made_with(500, 0.1)).width, usual.width);
}

TEST(ResidualPicture, ShowsTheResiduals) {
  auto made = made_with(3, 0.1);
  const GreyImage with = drawn(made);
  for (CalibratedView& view : made.views) view.residuals.clear();
  const GreyImage without = drawn(made);
  ASSERT_EQ(with.pixels.size(), without.pixels.size());
  EXPECT_NE(with.pixels, without.pixels);
}

// A panorama keeps room for the numbers beside it.
TEST(ResidualPicture, FitsAnyPicture) {
  auto made = made_with(3, 0.1);
  made.calibration.width = 32000;
  made.calibration.height = 10;
  EXPECT_GT(drawn(made).height, 500);
  std::swap(made.calibration.width, made.calibration.height);
  EXPECT_LT(drawn(made).height, 3000);
}

}  // namespace residual_picture_test
}  // namespace rack::camera_calibrate
