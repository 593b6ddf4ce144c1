#include "components/scan2d/picture_intensity.h"

#include <array>
#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::scan2d {
namespace picture_intensity_test {

using testing::HasSubstr;

CameraParamData camera() {
  return {.calibration_width = 320,
          .calibration_height = 240,
          .fx = 300,
          .fy = 300,
          .e0 = 160,
          .n0 = 120};
}

// The value of each pixel is its column, plus 100 in the lower half.
CameraData picture() {
  CameraData data{.width = 160, .height = 120, .depth = 8, .mode = camera_mode::kMono8};
  for (int row = 0; row < 120; ++row)
    for (int column = 0; column < 160; ++column)
      data.image.push_back(static_cast<std::byte>(column / 2 + (row >= 60 ? 100 : 0)));
  return data;
}

Scan2dData scan(std::initializer_list<std::pair<i32, i32>> places) {
  Scan2dData data;
  for (const auto& [x, y] : places) data.points.push_back({.x = x, .y = y, .intensity = 9});
  return data;
}

std::optional<Pixel> pixel(CameraView& view, const scan3d::Place& place) {
  const auto pixels = view.pixels(std::span(&place, 1), 320, 240);
  return pixels ? pixels->front() : std::nullopt;
}

TEST(CameraView, PointsAreWhereTheLensShowsThem) {
  // 0.3 m above the plane of the ladar: points appear below the middle of the picture.
  auto view = CameraView::make(camera(), {.z = -300});
  ASSERT_TRUE(view);
  Scan2dData seen =
      scan({{3000, 0}, {3000, 300}, {3000, -1500}, {-3000, 0}, {3000, 3000}, {400, 0}});
  ASSERT_TRUE(view->add_brightness(picture(), {}, seen));
  EXPECT_EQ(seen.points[0].intensity, 140);  // column 80 of 160
  EXPECT_EQ(seen.points[1].intensity, 147);  // 15 to the right
  EXPECT_EQ(seen.points[2].intensity, 102);  // 75 to the left
  EXPECT_EQ(seen.points[3].intensity, 0) << "behind it";
  EXPECT_EQ(seen.points[4].intensity, 0) << "beside it";
  EXPECT_EQ(seen.points[5].intensity, 0) << "below it";
}

TEST(CameraView, LooksWhereItIsMounted) {
  auto view = CameraView::make(camera(), {.x = 100, .y = 200, .z = -300, .rho = kPi / 2});
  Scan2dData seen = scan({{100, 3200}, {-200, 3200}});
  ASSERT_TRUE(view->add_brightness(picture(), {}, seen));
  EXPECT_EQ(seen.points[0].intensity, 140);
  EXPECT_EQ(seen.points[1].intensity, 147) << "facing right, behind the robot is on the right";
}

// The picture was taken a metre before the scan, and the robot has turned.
TEST(CameraView, TheRobotMovesBetweenScanAndPicture) {
  auto view = CameraView::make(camera(), {.z = -300});
  const Pose at_picture{.x = 500, .y = 700, .rho = 1};
  const Pose at_scan{.x = 1200, .y = 1400, .rho = 1.2};
  const Pose seen_then = Pose{} + Pose{.x = 3000, .y = 300};
  const Pose in_world = at_picture + seen_then;
  const Pose seen_now = in_world - at_scan;
  Scan2dData seen = scan({{whole_millimetres(seen_now.x), whole_millimetres(seen_now.y)}});
  ASSERT_TRUE(view->add_brightness(picture(), at_scan - at_picture, seen));
  EXPECT_NEAR(seen.points[0].intensity, 147, 1);
}

TEST(CameraView, TheLensBends) {
  CameraParamData lens = camera();
  lens.f = 4;
  lens.k1 = -0.1F;
  auto bent = CameraView::make(lens, {});
  auto straight = CameraView::make(camera(), {});
  const auto far = pixel(*straight, {1000, 400, 0});
  const auto near = pixel(*bent, {1000, 400, 0});
  ASSERT_TRUE(far && near);
  EXPECT_EQ(far->column, 280U);
  EXPECT_EQ(near->column, 160U + 89U);  // 120 * (1 - 0.1 * 1.6 * 1.6)
}

// Answers of our own projection, which OpenCV's replaced.
TEST(CameraView, KnownAnswers) {
  const CameraParamData lens{.calibration_width = 320,
                             .calibration_height = 240,
                             .f = 4,
                             .fx = 300,
                             .fy = 310,
                             .k1 = -0.02F,
                             .k2 = 0.001F,
                             .p1 = 0.002F,
                             .p2 = -0.003F,
                             .e0 = 158,
                             .n0 = 122};
  struct Answer {
    scan3d::Place place;
    Pixel pixel;
  };
  const std::array answers = {
      Answer{{1208, 368, -57}, {419, 329}},   Answer{{2406, -378, -289}, {106, 239}},
      Answer{{3286, -289, -151}, {149, 260}}, Answer{{2891, 1164, -484}, {433, 163}},
      Answer{{1908, -188, -473}, {140, 171}}, Answer{{2203, 1646, 106}, {603, 283}},
      Answer{{3116, -303, 111}, {150, 317}},  Answer{{2243, -764, 351}, {13, 438}},
      Answer{{3411, 871, -311}, {355, 206}},  Answer{{2962, -92, -180}, {186, 253}},
      Answer{{3067, 708, 185}, {351, 307}},   Answer{{2300, 409, -41}, {323, 283}}};
  auto view =
      CameraView::make(lens, {.x = 100, .y = -50, .z = -300, .phi = 0.1, .psi = -0.05, .rho = 0.2});
  ASSERT_TRUE(view);
  for (const auto& [place, expected] : answers) {
    const auto found = view->pixels(std::span(&place, 1), 640, 480);
    ASSERT_TRUE(found && found->front());
    EXPECT_EQ(found->front()->column, expected.column) << place.x;
    EXPECT_EQ(found->front()->row, expected.row) << place.x;
  }
}

TEST(CameraView, UnderstandsPixels) {
  auto view = CameraView::make(camera(), {});
  struct Case {
    u16 mode;
    std::size_t bytes;
    i16 wanted;
  };
  for (const auto& [mode, bytes, wanted] :
       {Case{camera_mode::kMono8, 1, 10}, Case{camera_mode::kMono16, 2, 10 * 256 + 20},
        Case{camera_mode::kYuv422, 2, 20}, Case{camera_mode::kRgb24, 3, 22}}) {
    CameraData data{.width = 4, .height = 2, .mode = mode};
    for (int i = 0; i < 8; ++i)
      for (std::size_t byte = 1; byte <= bytes; ++byte)
        data.image.push_back(static_cast<std::byte>(10 * byte));
    Scan2dData seen = scan({{2000, 0}});
    ASSERT_TRUE(view->add_brightness(data, {}, seen));
    EXPECT_EQ(seen.points[0].intensity, wanted) << mode;
  }
}

TEST(CameraView, RefusesWithAReason) {
  const auto none = CameraView::make({}, {});
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message(), HasSubstr("fx and fy"));
  CameraParamData odd = camera();
  odd.fx = NAN;
  EXPECT_FALSE(CameraView::make(odd, {}));
  auto view = CameraView::make(camera(), {});
  Scan2dData seen = scan({{2000, 0}});
  CameraData data = picture();
  data.mode = camera_mode::kJpeg;
  EXPECT_THAT(view->add_brightness(data, {}, seen).error().message(), HasSubstr("mode 41"));
  data = picture();
  data.image.resize(100);
  EXPECT_THAT(view->add_brightness(data, {}, seen).error().message(), HasSubstr("fewer bytes"));
  EXPECT_EQ(seen.points[0].intensity, 9) << "stays";
}

TEST(CameraView, TakesAnyNumbers) {
  std::mt19937 random(5);
  const auto any = [&] {
    constexpr float kOdd[] = {NAN, INFINITY, -INFINITY, 0, 1e30F, -1e30F, 300, 1e-20F};
    return kOdd[random() % std::size(kOdd)];
  };
  for (int i = 0; i < 20000; ++i) {
    const CameraParamData lens{.calibration_width = static_cast<i32>(random() % 1000),
                               .calibration_height = 240,
                               .f = any(),
                               .fx = any(),
                               .fy = 300,
                               .k1 = any(),
                               .k2 = any(),
                               .p1 = any(),
                               .p2 = any(),
                               .e0 = any(),
                               .n0 = 120};
    auto view = CameraView::make(lens, {.x = static_cast<double>(any()), .rho = 1});
    if (!view) continue;
    Scan2dData seen = scan({{static_cast<i32>(random()), static_cast<i32>(random())}, {0, 0}});
    ASSERT_TRUE(view->add_brightness(picture(), {.x = static_cast<double>(any())}, seen));
  }
}

}  // namespace picture_intensity_test
}  // namespace rack::scan2d
