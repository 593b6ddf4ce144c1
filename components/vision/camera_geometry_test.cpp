#include "components/vision/camera_geometry.h"

#include <gtest/gtest.h>

namespace rack::vision {
namespace camera_geometry_test {

CameraParamData parameters() {
  CameraParamData data;
  data.calibration_width = 640;
  data.calibration_height = 480;
  data.fx = 500;
  data.fy = 510;
  data.e0 = 330;
  data.n0 = 250;
  return data;
}

TEST(CameraGeometry, ALensOfAnotherSizeIsScaled) {
  const auto camera = CameraGeometry::make(parameters(), 320, 240, {});
  ASSERT_TRUE(camera);
  EXPECT_DOUBLE_EQ(camera->lens().fx, 250);
  EXPECT_DOUBLE_EQ(camera->lens().fy, 255);
  EXPECT_DOUBLE_EQ(camera->lens().cx, 165);
  EXPECT_DOUBLE_EQ(camera->lens().cy, 125);
}

TEST(CameraGeometry, AnUnknownPrincipalPointIsTheMiddle) {
  CameraParamData data = parameters();
  data.e0 = data.n0 = 0;
  EXPECT_DOUBLE_EQ(CameraGeometry::make(data, 640, 480, {})->lens().cx, 320);
  EXPECT_DOUBLE_EQ(CameraGeometry::make(data, 640, 480, {})->lens().cy, 240);
}

TEST(CameraGeometry, NeedsAFocalLength) {
  for (const float wrong : {0.0F, -1.0F, std::numeric_limits<float>::quiet_NaN()}) {
    CameraParamData data = parameters();
    data.fx = wrong;
    const auto camera = CameraGeometry::make(data, 640, 480, {});
    ASSERT_FALSE(camera);
    EXPECT_NE(camera.error().detail().find("camera-calibrate"), std::string::npos);
  }
  CameraParamData data = parameters();
  data.calibration_width = 0;
  EXPECT_FALSE(CameraGeometry::make(data, 640, 480, {}));
}

TEST(CameraGeometry, PlacesAndPixels) {
  const auto camera = *CameraGeometry::make(parameters(), 640, 480, {.x = 100, .z = -500});
  const auto pixel = camera.pixel({2100, 400, -900});  // to the right, and above the lens
  ASSERT_TRUE(pixel);
  EXPECT_NEAR(pixel->column, 330 + 500 * 400.0 / 2000, 1e-9);
  EXPECT_NEAR(pixel->row, 250 - 510 * 400.0 / 2000, 1e-9);
  EXPECT_FALSE(camera.pixel({100, 0, -500})) << "in the lens";
  EXPECT_FALSE(camera.pixel({-1000, 0, -500})) << "behind it";
}

TEST(CameraGeometry, PixelsShowTheGroundBelowTheHorizon) {
  for (const double tilt : {0.0, -0.3, 0.1}) {
    const auto camera = *CameraGeometry::make(parameters(), 640, 480,
                                              {.x = 100, .z = -500, .psi = tilt, .rho = 0.2});
    const scan3d::Place place{1500, 300, 0};
    const auto pixel = camera.pixel(place);
    ASSERT_TRUE(pixel);
    const auto ground = camera.ground(*pixel);
    ASSERT_TRUE(ground);
    EXPECT_NEAR(ground->x, place.x, 1e-6);
    EXPECT_NEAR(ground->y, place.y, 1e-6);
    EXPECT_NEAR(ground->z, 0, 1e-6);
    EXPECT_FALSE(camera.ground({320, -2000}));
  }
  const auto buried = *CameraGeometry::make(parameters(), 640, 480, {.z = 10});
  EXPECT_FALSE(buried.ground({320, 400})) << "the lens is not above the ground";
}

}  // namespace camera_geometry_test
}  // namespace rack::vision
