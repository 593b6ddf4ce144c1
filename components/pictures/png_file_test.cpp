#include "components/pictures/png_file.h"

#include <array>
#include <limits>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "components/pictures/jpeg.h"

namespace rack::pictures {
namespace png_file_test {

cv::Mat decoded(const PixelView& pixels, std::span<const LabelledBox> boxes = {}) {
  const auto png = encode_png({.pixels = pixels}, boxes);
  EXPECT_TRUE(png) << png.error().message();
  if (!png) return {};
  const cv::Mat bytes(1, static_cast<int>(png->size()), CV_8UC1,
                      const_cast<std::byte*>(png->data()));
  return cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
}

template <std::size_t N>
std::array<std::byte, N> bytes(const std::array<int, N>& values) {
  std::array<std::byte, N> all{};
  for (std::size_t i = 0; i < N; ++i) all.at(i) = static_cast<std::byte>(values.at(i));
  return all;
}

TEST(PngFile, HasThePixelsOfEachForm) {
  const auto data = bytes<12>({10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120});
  EXPECT_EQ(decoded({PixelLayout::kGrey, {4, 3}, data}).at<std::uint8_t>(1, 2), 70);
  EXPECT_EQ(decoded({PixelLayout::kBig16, {3, 2}, data}).at<std::uint16_t>(1, 0), 70 * 256 + 80);
  EXPECT_EQ(decoded({PixelLayout::kRgb, {2, 2}, data}).at<cv::Vec3b>(1, 0), cv::Vec3b(90, 80, 70));
  const auto grey = bytes<4>({128, 235, 128, 16});
  const cv::Mat pair = decoded({PixelLayout::kUyvy, {2, 1}, grey});
  EXPECT_EQ(pair.at<cv::Vec3b>(0, 0), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(pair.at<cv::Vec3b>(0, 1), cv::Vec3b(0, 0, 0));
}

TEST(PngFile, RefusesASizeThatDoesNotFit) {
  const auto data = bytes<12>({});
  EXPECT_TRUE(encode_png({.pixels = {PixelLayout::kGrey, {12, 1}, data}}));
  EXPECT_FALSE(encode_png({.pixels = {PixelLayout::kGrey, {11, 1}, data}}));
  EXPECT_FALSE(encode_png({.pixels = {PixelLayout::kGrey, {13, 1}, data}}));
  EXPECT_FALSE(encode_png({.pixels = {PixelLayout::kGrey, {0, 0}, {}}}));
  EXPECT_TRUE(encode_png({.pixels = {PixelLayout::kUyvy, {6, 1}, data}}));
  EXPECT_FALSE(encode_png({.pixels = {PixelLayout::kUyvy, {3, 2}, data}}))
      << "colours are shared by two pixels";
}

TEST(PngFile, DrawsBoxesWithTheirLabels) {
  const std::vector<std::byte> black(std::size_t{200} * 100);
  const std::array<LabelledBox, 1> boxes = {{{50, 40, 60, 30, "7"}}};
  const cv::Mat drawn = decoded({PixelLayout::kGrey, {200, 100}, black}, boxes);
  ASSERT_EQ(drawn.type(), CV_8UC3);
  const auto is_green = [&](int column, int row) {
    const auto& pixel = drawn.at<cv::Vec3b>(row, column);
    return pixel[1] > 150 && pixel[2] < 100;
  };
  EXPECT_TRUE(is_green(50, 55));
  EXPECT_TRUE(is_green(110, 55));
  EXPECT_TRUE(is_green(80, 70));
  EXPECT_FALSE(is_green(80, 55));
  EXPECT_FALSE(is_green(48, 55));
  const cv::Mat label = drawn(cv::Rect(50, 20, 20, 18));
  EXPECT_GT(cv::countNonZero(cv::Mat(label.clone().reshape(1))), 10);
}

TEST(PngFile, BoxesMayBeOutsideOfThePicture) {
  const std::vector<std::byte> words(std::size_t{2} * 40 * 20);
  constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
  constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min();
  const std::array<LabelledBox, 3> boxes = {{{kMost, kMost, kMost, kMost, "right"},
                                             {kLeast, kLeast, kMost, kMost, "left"},
                                             {-5, -5, 100, 100, "wider than the picture"}}};
  const cv::Mat drawn = decoded({PixelLayout::kBig16, {40, 20}, words}, boxes);
  EXPECT_EQ(drawn.size(), cv::Size(40, 20));
}

TEST(PngFile, JpegIsDecoded) {
  const std::vector<std::byte> grey(std::size_t{64} * 48, std::byte{200});
  std::vector<std::byte> jpeg;
  ASSERT_TRUE(Jpeg().encode({PixelLayout::kGrey, {64, 48}, grey}, 90, 100000, jpeg));
  const auto png = encode_png({.jpeg = jpeg});
  ASSERT_TRUE(png) << png.error().message();
  jpeg.resize(jpeg.size() / 3);
  const auto damaged = encode_png({.jpeg = jpeg});
  ASSERT_FALSE(damaged);
  EXPECT_EQ(damaged.error().code(), tims::Errc::kMalformed);
}

}  // namespace png_file_test
}  // namespace rack::pictures
