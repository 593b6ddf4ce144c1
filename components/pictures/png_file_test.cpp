#include "components/pictures/png_file.h"

#include <array>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

namespace rack::pictures {
namespace png_file_test {

cv::Mat decoded(const RawPicture& picture) {
  const auto png = encode_png(picture);
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
  EXPECT_EQ(decoded({RawForm::kGrey, 4, 3, data}).at<std::uint8_t>(1, 2), 70);
  EXPECT_EQ(decoded({RawForm::kGrey16, 3, 2, data}).at<std::uint16_t>(1, 0), 70 * 256 + 80);
  EXPECT_EQ(decoded({RawForm::kRgb, 2, 2, data}).at<cv::Vec3b>(1, 0), cv::Vec3b(90, 80, 70));
  const auto grey = bytes<4>({128, 235, 128, 16});
  const cv::Mat pair = decoded({RawForm::kUyvy, 2, 1, grey});
  EXPECT_EQ(pair.at<cv::Vec3b>(0, 0), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(pair.at<cv::Vec3b>(0, 1), cv::Vec3b(0, 0, 0));
}

TEST(PngFile, RefusesASizeThatDoesNotFit) {
  const auto data = bytes<12>({});
  EXPECT_TRUE(encode_png({RawForm::kGrey, 12, 1, data}));
  EXPECT_FALSE(encode_png({RawForm::kGrey, 11, 1, data}));
  EXPECT_FALSE(encode_png({RawForm::kGrey, 13, 1, data}));
  EXPECT_FALSE(encode_png({RawForm::kGrey, -12, -1, data}));
  EXPECT_FALSE(encode_png({RawForm::kGrey, 0, 0, {}}));
  EXPECT_TRUE(encode_png({RawForm::kUyvy, 6, 1, data}));
  EXPECT_FALSE(encode_png({RawForm::kUyvy, 3, 2, data})) << "colours are shared by two pixels";
}

}  // namespace png_file_test
}  // namespace rack::pictures
