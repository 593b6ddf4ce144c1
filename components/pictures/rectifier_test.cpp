#include "components/pictures/rectifier.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/rendered_board.h"

namespace rack::pictures {
namespace rectifier_test {

using tims::test::RenderedCamera;

constexpr int kWidth = 320;
constexpr int kHeight = 240;

CameraCalibration lens() {
  return {.width = kWidth,
          .height = kHeight,
          .camera = {.fx = 250, .fy = 248, .cx = 163, .cy = 116},
          .distortion = {-0.3, 0.1, 0.002, -0.001, 0},
          .rectified = {.fx = 230, .fy = 230, .cx = 160, .cy = 120}};
}

// Where a dark line through each row of the picture is, pixels. Not of rows at the edge, of which
// the camera saw a part only.
std::vector<double> line_in(const std::vector<std::byte>& pixels) {
  std::vector<double> places;
  for (std::size_t y = 15; y < kHeight - 15; ++y) {
    double sum = 0;
    double weighted = 0;
    for (std::size_t x = 0; x < kWidth; ++x) {
      const int dark = std::max(200 - std::to_integer<int>(pixels[y * kWidth + x]), 0);
      sum += dark;
      weighted += dark * static_cast<double>(x);
    }
    places.push_back(sum > 0 ? weighted / sum : NAN);
  }
  return places;
}

TEST(Rectifier, StraightLinesAreStraight) {
  const RenderedCamera camera(lens(), 4);
  const auto rectifier = Rectifier::make(lens());
  ASSERT_TRUE(rectifier);
  for (const double at : {-0.5, -0.1, 0.3, 0.55}) {
    const auto seen =
        camera.render([&](double x, double) { return std::abs(x - at) < 0.02 ? 0.0 : 1.0; });
    std::vector<std::byte> rectified(seen.size());
    // White beside the picture, too.
    ASSERT_TRUE(rectifier->rectify({.bytes = seen, .border = 255}, rectified));
    const double expected = 230 * at + 160;
    for (const double place : line_in(rectified)) EXPECT_NEAR(place, expected, 0.2) << at;
    const auto before = line_in(seen);
    const auto [least, most] = std::ranges::minmax(before);
    if (std::abs(at) > 0.4) {
      EXPECT_GT(most - least, 5) << at;
    }
  }
}

// Sizes at and below what is required, padded lines, all kinds of pixels.
TEST(Rectifier, PixelsOfAllKinds) {
  CameraCalibration shifted{.width = 8,
                            .height = 4,
                            .camera = {.fx = 8, .fy = 8, .cx = 4, .cy = 2},
                            .distortion = {0, 0, 0, 0, 0}};
  shifted.rectified = shifted.camera;
  shifted.rectified.cx += 1;  // pictures move to the right by one pixel
  const auto rectifier = Rectifier::make(shifted);
  ASSERT_TRUE(rectifier);
  for (const std::size_t channels : {1U, 2U, 3U, 4U})
    for (const std::size_t channel_bytes : {1U, 2U})
      for (const std::size_t padding : {0U, 5U}) {
        const std::size_t pixel = channels * channel_bytes;
        const std::size_t line = 8 * pixel + padding * channel_bytes;
        std::vector<std::byte> from(line * 3 + 8 * pixel);
        for (std::size_t i = 0; i < from.size(); ++i) from[i] = static_cast<std::byte>(i);
        std::vector<std::byte> to(32 * pixel);
        const Raster raster{.bytes = from,
                            .channels = static_cast<int>(channels),
                            .channel_bytes = static_cast<int>(channel_bytes),
                            .line_bytes = padding == 0 ? 0 : line};
        ASSERT_TRUE(rectifier->rectify(raster, to));
        for (std::size_t y = 0; y < 4; ++y) {
          EXPECT_EQ(to[y * 8 * pixel], std::byte{0});  // border
          EXPECT_TRUE(std::equal(from.begin() + static_cast<std::ptrdiff_t>(y * line),
                                 from.begin() + static_cast<std::ptrdiff_t>(y * line + 7 * pixel),
                                 to.begin() + static_cast<std::ptrdiff_t>((8 * y + 1) * pixel)));
        }
        const std::span whole(from);
        Raster short_one = raster;
        short_one.bytes = whole.first(whole.size() - 1);
        EXPECT_EQ(rectifier->rectify(short_one, to).error().code(), tims::Errc::kMalformed);
        EXPECT_FALSE(rectifier->rectify(raster, std::span(to).first(to.size() - 1)));
      }
  std::vector<std::byte> to(200);
  for (const Raster& wrong :
       {Raster{.bytes = to, .channels = 5}, Raster{.bytes = to, .channels = 0},
        Raster{.bytes = to, .channel_bytes = 3}})
    EXPECT_EQ(rectifier->rectify(wrong, to).error().code(), tims::Errc::kInvalidArgument);
}

TEST(Rectifier, PicturesAreLimited) {
  CameraCalibration large = lens();
  large.width = 4096;
  large.height = 4097;
  EXPECT_EQ(Rectifier::make(large).error().code(), tims::Errc::kTooBig);
  large.width = 0;
  EXPECT_FALSE(Rectifier::make(large));
  large.width = kCalibrationSideMax + 1;
  large.height = 1;
  EXPECT_FALSE(Rectifier::make(large));
  large.width = kCalibrationSideMax;
  EXPECT_TRUE(Rectifier::make(large));
}

}  // namespace rectifier_test
}  // namespace rack::pictures
