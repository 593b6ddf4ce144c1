#include "tools/camera_calibrate/grey_image.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/camera/picture.h"

namespace rack::camera_calibrate {
namespace grey_image_test {

using testing::HasSubstr;

std::vector<int> numbers(const GreyImage& image) {
  std::vector<int> all;
  all.reserve(image.pixels.size());
  for (const std::byte pixel : image.pixels) all.push_back(std::to_integer<int>(pixel));
  return all;
}

CameraData picture_of(u16 mode, u16 width, u16 height, std::initializer_list<int> bytes) {
  CameraData picture;
  picture.mode = mode;
  picture.width = width;
  picture.height = height;
  for (const int byte : bytes) picture.image.push_back(static_cast<std::byte>(byte));
  return picture;
}

TEST(GreyImage, IsReadFromFiles) {
  const auto pgm = grey_of_file(std::string_view("P5\n2 2\n255\n\x01\x02\x03\xFF", 15));
  ASSERT_TRUE(pgm) << pgm.error().detail();
  EXPECT_EQ(pgm->width, 2);
  EXPECT_THAT(numbers(*pgm), testing::ElementsAre(1, 2, 3, 255));
  EXPECT_THAT(numbers(*grey_of_file("P2\n2 1\n1000\n0 1000\n")), testing::ElementsAre(0, 255));
  const auto png = png_of(*pgm);
  ASSERT_TRUE(png);
  EXPECT_EQ(numbers(*grey_of_file(*png)), numbers(*pgm));
  device::PictureMaker maker;
  CameraData jpeg;
  ASSERT_TRUE(maker.compress(picture_of(camera_mode::kMono8, 2, 1, {128, 128}), jpeg));
  const std::string bytes(reinterpret_cast<const char*>(jpeg.image.data()), jpeg.image.size());
  EXPECT_THAT(numbers(*grey_of_file(bytes)),
              testing::Each(testing::AllOf(testing::Ge(126), testing::Le(130))));
  EXPECT_FALSE(grey_of_file(bytes.substr(0, bytes.size() / 2)));
}

TEST(GreyImage, OtherFilesAreRefused) {
  for (const char* text : {"", "GIF89a", "BM", "P6\n1 1\n255\nabc", "\x89PNG", "\xFF\xD8"}) {
    const auto image = grey_of_file(text);
    ASSERT_FALSE(image) << text;
    EXPECT_FALSE(image.error().detail().empty());
  }
  EXPECT_THAT(grey_of_file("GIF89a").error().detail(), HasSubstr("not a PNG, PGM or JPEG"));
}

TEST(GreyImage, IsMadeOfEachMode) {
  EXPECT_THAT(numbers(*grey_of(picture_of(camera_mode::kMono8, 2, 1, {7, 9}))),
              testing::ElementsAre(7, 9));
  EXPECT_THAT(numbers(*grey_of(picture_of(camera_mode::kYuv422, 2, 1, {128, 7, 128, 9}))),
              testing::ElementsAre(7, 9));
  EXPECT_THAT(numbers(*grey_of(picture_of(camera_mode::kRgb24, 1, 1, {50, 50, 50}))),
              testing::ElementsAre(50));
  // Stretched, big-endian.
  EXPECT_THAT(numbers(*grey_of(picture_of(camera_mode::kMono16, 3, 1, {16, 0, 16, 2, 16, 4}))),
              testing::ElementsAre(0, 127, 255));
  EXPECT_THAT(numbers(*grey_of(picture_of(camera_mode::kMono16, 2, 1, {16, 0, 16, 0}))),
              testing::ElementsAre(0, 0));
}

TEST(GreyImage, PicturesThatAreNoneAreRefused) {
  EXPECT_THAT(grey_of(picture_of(camera_mode::kRange, 1, 1, {1, 2})).error().detail(),
              HasSubstr("set mode to mono8"));
  for (const auto& picture :
       {picture_of(camera_mode::kMono8, 0, 1, {}), picture_of(camera_mode::kMono8, 2, 2, {1, 2, 3}),
        picture_of(camera_mode::kMono16, 2, 1, {1, 2, 3}),
        picture_of(camera_mode::kYuv422, 3, 1, {1, 2, 3, 4, 5, 6}),
        picture_of(camera_mode::kJpeg, 2, 1, {0xFF, 0xD8, 1})})
    EXPECT_FALSE(grey_of(picture)) << picture.mode;
}

}  // namespace grey_image_test
}  // namespace rack::camera_calibrate
