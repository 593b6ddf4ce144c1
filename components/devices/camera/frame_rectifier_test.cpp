#include "components/devices/camera/frame_rectifier.h"

#include <array>
#include <bit>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::device {
namespace frame_rectifier_test {

using testing::ElementsAre;
using testing::HasSubstr;
using Bytes = std::vector<std::byte>;

constexpr std::uint32_t kNativeGrey16 =
    video::kGrey16 | (std::endian::native == std::endian::big ? video::kBigEndian : 0);

// Pictures of 8x2 pixels move to the right by two pixels.
pictures::CameraCalibration shift() {
  pictures::CameraCalibration calibration{.width = 8,
                                          .height = 2,
                                          .camera = {.fx = 8, .fy = 8, .cx = 4, .cy = 1},
                                          .distortion = {0, 0, 0, 0, 0}};
  calibration.rectified = calibration.camera;
  calibration.rectified.cx += 2;
  return calibration;
}

Bytes counted(std::size_t count, int from = 10) {
  Bytes bytes;
  for (std::size_t i = 0; i < count; ++i)
    bytes.push_back(static_cast<std::byte>(static_cast<std::size_t>(from) + i));
  return bytes;
}

std::vector<int> numbers(std::span<const std::byte> bytes) {
  std::vector<int> all;
  for (const std::byte byte : bytes) all.push_back(std::to_integer<int>(byte));
  return all;
}

struct FrameRectifierTest : testing::Test {
  FrameRectifier rectifier_{shift()};
};

TEST_F(FrameRectifierTest, FramesKeepTheirFormat) {
  struct Case {
    std::uint32_t format;
    std::uint32_t pixel;  // bytes
  };
  for (const Case& one : {Case{video::kGrey, 1}, Case{video::kRgb24, 3}, Case{video::kBgr24, 3},
                          Case{kNativeGrey16, 2}, Case{video::kYuyv, 2}, Case{video::kUyvy, 2}}) {
    // Lines are padded by 4 bytes.
    const std::uint32_t line = 8 * one.pixel + 4;
    const Bytes frame = counted(std::size_t{2} * line);
    const auto made = rectifier_.rectify({one.format, 8, 2, line}, frame, camera_mode::kRgb24);
    ASSERT_TRUE(made) << letters_of(one.format) << made.error().detail();
    EXPECT_EQ(made->head, (VideoHead{one.format, 8, 2, 8 * one.pixel}));
    const std::size_t moved = std::size_t{2} * one.pixel;
    const std::size_t row_bytes = std::size_t{8} * one.pixel;
    for (std::size_t y = 0; y < 2; ++y) {
      const auto row = made->bytes.subspan(y * row_bytes, row_bytes);
      EXPECT_TRUE(std::ranges::equal(row.subspan(moved),
                                     std::span(frame).subspan(y * line, row_bytes - moved)))
          << letters_of(one.format);
    }
  }
}

// Between two pixels: of bytes in the wrong order, another mean.
TEST(FrameRectifierNumbers, AreRectifiedInBothOrdersOfBytes) {
  pictures::CameraCalibration between = shift();
  between.rectified.cx += 0.5;
  for (const std::uint32_t format : {video::kGrey16, video::kGrey16 | video::kBigEndian}) {
    const int high = format == video::kGrey16 ? 1 : 0;
    Bytes frame(32);
    for (std::size_t i = 0; i < 16; ++i) {
      const unsigned value = i % 2 == 0 ? 0x00FF : 0x0101;
      frame[2 * i + static_cast<std::size_t>(high)] = static_cast<std::byte>(value >> 8);
      frame[2 * i + static_cast<std::size_t>(1 - high)] = static_cast<std::byte>(value & 0xFF);
    }
    FrameRectifier rectifier{between};
    const auto made = rectifier.rectify({format, 8, 2, 16}, frame, camera_mode::kMono16);
    ASSERT_TRUE(made) << made.error().detail();
    EXPECT_EQ(made->head.format, kNativeGrey16);
    std::array<std::uint16_t, 16> pixels{};
    ASSERT_EQ(made->bytes.size(), sizeof pixels);
    std::memcpy(pixels.data(), made->bytes.data(), sizeof pixels);
    EXPECT_EQ(pixels[5], 0x0100) << letters_of(format);
  }
}

TEST_F(FrameRectifierTest, TheBorderIsBlackNotGreen) {
  const auto made = rectifier_.rectify({video::kYuyv, 8, 2, 16}, counted(32), camera_mode::kYuv422);
  ASSERT_TRUE(made);
  EXPECT_THAT(numbers(made->bytes.first(6)), ElementsAre(0, 128, 0, 128, 10, 11));
}

TEST_F(FrameRectifierTest, GreyPicturesNeedNoColours) {
  const auto made = rectifier_.rectify({video::kUyvy, 8, 2, 16}, counted(32), camera_mode::kMono8);
  ASSERT_TRUE(made);
  EXPECT_EQ(made->head, (VideoHead{video::kGrey, 8, 2, 8}));
  EXPECT_THAT(numbers(made->bytes.first(4)), ElementsAre(0, 0, 11, 13));
}

TEST_F(FrameRectifierTest, JpegIsDecoded) {
  PictureMaker maker(100);
  CameraData jpeg;
  const Bytes bright(48, std::byte{200});
  ASSERT_TRUE(maker.make({video::kRgb24, 8, 2, 24}, bright, camera_mode::kJpeg, jpeg));
  const auto colour = rectifier_.rectify({.format = video::kMjpeg}, jpeg.image, camera_mode::kJpeg);
  ASSERT_TRUE(colour);
  EXPECT_EQ(colour->head, (VideoHead{video::kBgr24, 8, 2, 24}));
  EXPECT_EQ(colour->bytes[0], std::byte{0});
  EXPECT_NEAR(std::to_integer<int>(colour->bytes[12]), 200, 3);
  const auto grey = rectifier_.rectify({.format = video::kJpeg}, jpeg.image, camera_mode::kMono8);
  ASSERT_TRUE(grey);
  EXPECT_EQ(grey->head, (VideoHead{video::kGrey, 8, 2, 8}));
  const auto half = std::span(jpeg.image).first(jpeg.image.size() / 2);
  EXPECT_EQ(rectifier_.rectify({.format = video::kJpeg}, half, camera_mode::kJpeg).error().code(),
            tims::Errc::kMalformed);
}

TEST_F(FrameRectifierTest, TheCalibrationFollowsTheSize) {
  for (const std::uint32_t width : {8U, 16U, 8U}) {
    const Bytes frame = counted(std::size_t{width} * width / 4);
    const auto made =
        rectifier_.rectify({video::kGrey, width, width / 4, width}, frame, camera_mode::kMono8);
    ASSERT_TRUE(made) << made.error().detail();
    EXPECT_EQ(made->bytes[width / 4], std::byte{10});
  }
  const auto other = rectifier_.rectify({video::kGrey, 8, 8, 8}, counted(64), camera_mode::kMono8);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code(), tims::Errc::kInvalidArgument);
  EXPECT_THAT(other.error().detail(), HasSubstr("8x2 pixels, those of the camera have 8x8"));
}

TEST_F(FrameRectifierTest, WhatCannotBeRectifiedIsRefused) {
  for (const u16 mode : {camera_mode::kRange, camera_mode::kDisparity})
    EXPECT_THAT(rectifier_.rectify({video::kGrey, 8, 2, 8}, counted(16), mode).error().detail(),
                HasSubstr("are not rectified"));
  const auto depth =
      rectifier_.rectify({video::kDepth16, 8, 2, 16}, counted(32), camera_mode::kMono16);
  EXPECT_EQ(depth.error().code(), tims::Errc::kInvalidArgument);
  const auto unknown =
      rectifier_.rectify({four_letters("H264"), 8, 2, 8}, counted(16), camera_mode::kMono8);
  EXPECT_THAT(unknown.error().detail(), HasSubstr("H264"));
  const auto cut = rectifier_.rectify({video::kGrey, 8, 2, 8}, counted(15), camera_mode::kMono8);
  EXPECT_EQ(cut.error().code(), tims::Errc::kMalformed);
  // Two pixels of 9 share colours with nobody.
  pictures::CameraCalibration odd = shift();
  odd.width = 9;
  FrameRectifier of_odd(odd);
  EXPECT_EQ(
      of_odd.rectify({video::kYuyv, 9, 2, 18}, counted(36), camera_mode::kRgb24).error().code(),
      tims::Errc::kMalformed);
}

}  // namespace frame_rectifier_test
}  // namespace rack::device
