#include "components/devices/camera/camera_intrinsics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::device {
namespace camera_intrinsics_test {

using testing::HasSubstr;

const pictures::CameraCalibration& calibration() {
  static const pictures::CameraCalibration the_one{
      .width = 640,
      .height = 480,
      .camera = {.fx = 500, .fy = 500, .cx = 320, .cy = 240},
      .distortion = {-0.2, 0, 0, 0, 0},
      .rectified = {.fx = 400, .fy = 410, .cx = 319.5, .cy = 239.5}};
  return the_one;
}

TEST(CameraIntrinsics, AreThoseOfRectifiedPictures) {
  const auto half = rectified_intrinsics(calibration(), 320, 240);
  ASSERT_TRUE(half);
  EXPECT_EQ(half->calibration_width, 320);
  EXPECT_EQ(half->calibration_height, 240);
  EXPECT_FLOAT_EQ(half->fx.raw(), 200);
  EXPECT_FLOAT_EQ(half->fy.raw(), 205);
  EXPECT_FLOAT_EQ(half->e0.raw(), 159.5);
  EXPECT_FLOAT_EQ(half->n0.raw(), 119.5);
  EXPECT_EQ(half->k1.raw(), 0);
  EXPECT_EQ(half->coordinateRotation[4], 1);
  EXPECT_FALSE(rectified_intrinsics(calibration(), 640, 360));
}

TEST(CameraIntrinsics, ValuesThatContradictAreNamed) {
  const auto known = *rectified_intrinsics(calibration(), 640, 480);
  CameraParamData given;
  EXPECT_TRUE(check_intrinsics(given, known));  // nothing is set
  given = known;
  EXPECT_TRUE(check_intrinsics(given, known));
  given.fx = 404;
  EXPECT_TRUE(check_intrinsics(given, known));
  given.fx = 404.1F;
  EXPECT_THAT(
      check_intrinsics(given, known).error().detail(),
      HasSubstr("fx=404.1 contradicts the calibration, in which it is 400.0 for pictures of "
                "640x480"));
  given = known;
  given.n0 = known.n0.raw() + 4.9F;
  EXPECT_FALSE(check_intrinsics(given, known));
  given.n0 = known.n0.raw() + 4.7F;
  EXPECT_TRUE(check_intrinsics(given, known));
  given.e0 = 300;
  EXPECT_THAT(check_intrinsics(given, known).error().detail(), HasSubstr("e0=300"));
  given.fy = 1;
  EXPECT_THAT(check_intrinsics(given, known).error().detail(), HasSubstr("fy=1 "));
}

}  // namespace camera_intrinsics_test
}  // namespace rack::device
