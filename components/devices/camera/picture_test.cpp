#include "components/devices/camera/picture.h"

#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/devices/camera/stereo.h"
#include "components/recordings/capture.h"

namespace rack::device {
namespace picture_test {

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> all;
  for (const int value : values) all.push_back(static_cast<std::byte>(value));
  return all;
}

std::vector<std::vector<std::byte>> frames() {
  std::ifstream file(DEVICE_DATA "/camera/donkeycar-20.cap");
  std::vector<std::vector<std::byte>> all;
  CaptureRecord record;
  for (std::string line; std::getline(file, line);)
    if (parse_record(line, record).value()) all.push_back(record.bytes);
  return all;
}

constexpr VideoHead kJpegHead{.format = video::kMjpeg};

TEST(JpegTest, FramesOfACameraPassAsTheyAre) {
  PictureMaker maker;
  CameraData picture;
  const auto all = frames();
  ASSERT_EQ(all.size(), 20U);
  for (const auto& frame : all) {
    ASSERT_TRUE(maker.make(kJpegHead, frame, camera_mode::kJpeg, picture));
    EXPECT_EQ(picture.width, 160);
    EXPECT_EQ(picture.height, 120);
    EXPECT_EQ(picture.mode, camera_mode::kJpeg);
    EXPECT_EQ(picture.colorFilterId, frame.size());
    EXPECT_EQ(std::vector<std::byte>(picture.image), frame);
  }
}

TEST(JpegTest, FramesBecomePixels) {
  PictureMaker maker;
  CameraData rgb;
  CameraData grey;
  CameraData yuv;
  const auto frame = frames()[0];
  ASSERT_TRUE(maker.make(kJpegHead, frame, camera_mode::kRgb24, rgb));
  ASSERT_TRUE(maker.make(kJpegHead, frame, camera_mode::kMono8, grey));
  ASSERT_TRUE(maker.make(kJpegHead, frame, camera_mode::kYuv422, yuv));
  EXPECT_EQ(rgb.image.size(), 160U * 120 * 3);
  EXPECT_EQ(grey.image.size(), 160U * 120);
  EXPECT_EQ(yuv.image.size(), 160U * 120 * 2);
  EXPECT_EQ(rgb.depth, 24);
  // The brightness is the same in both modes.
  EXPECT_NEAR(*brightness_of(rgb, 1), *brightness_of(grey, 1), 12);
  EXPECT_NEAR(*brightness_of(yuv, 1), *brightness_of(grey, 1), 1);
  EXPECT_EQ(yuv.image[1], grey.image[0]);
}

TEST(JpegTest, AFrameWithoutTablesGetsThem) {
  const auto frame = frames()[0];
  std::vector<std::byte> bare(frame.begin(), frame.begin() + 2);
  std::size_t at = 2;
  while (frame[at + 1] != std::byte{0xDA}) {
    const std::size_t size = (std::to_integer<std::size_t>(frame[at + 2]) << 8 |
                              std::to_integer<std::size_t>(frame[at + 3])) +
                             2;
    if (frame[at + 1] != std::byte{0xC4})
      bare.insert(bare.end(), frame.begin() + static_cast<std::ptrdiff_t>(at),
                  frame.begin() + static_cast<std::ptrdiff_t>(at + size));
    at += size;
  }
  bare.insert(bare.end(), frame.begin() + static_cast<std::ptrdiff_t>(at), frame.end());
  bare.resize(bare.size() + 100);  // padded like a camera's buffer
  PictureMaker maker;
  CameraData picture;
  ASSERT_LT(bare.size(), frame.size());
  ASSERT_TRUE(maker.make(kJpegHead, bare, camera_mode::kJpeg, picture));
  CameraData pixels;
  ASSERT_TRUE(maker.make(kJpegHead, picture.image, camera_mode::kMono8, pixels));
  EXPECT_NEAR(static_cast<double>(picture.image.size()), static_cast<double>(frame.size()), 60);
}

TEST(JpegTest, CutAndFlippedFramesBreakNothing) {
  PictureMaker maker;
  CameraData picture;
  const auto frame = frames()[3];
  for (std::size_t size = 0; size < frame.size(); size += 7) {
    const auto cut = std::span(frame).first(size);
    EXPECT_FALSE(maker.make(kJpegHead, cut, camera_mode::kJpeg, picture)) << size;
    (void)maker.make(kJpegHead, cut, camera_mode::kRgb24, picture);
  }
  for (std::size_t bit = 0; bit < frame.size() * 8; bit += 5) {
    auto flipped = frame;
    flipped[bit / 8] ^= static_cast<std::byte>(1 << bit % 8);
    (void)maker.make(kJpegHead, flipped, camera_mode::kMono8, picture);
  }
  // After these errors, a valid picture can still be decoded.
  EXPECT_TRUE(maker.make(kJpegHead, frame, camera_mode::kRgb24, picture));
}

// Changes the size in the header of a JPEG.
std::vector<std::byte> resized(std::vector<std::byte> jpeg, int width, int height) {
  for (std::size_t i = 2; i + 8 < jpeg.size(); ++i) {
    if (jpeg[i] != std::byte{0xFF} || jpeg[i + 1] != std::byte{0xC0}) continue;
    for (const auto& [at, value] : {std::pair{i + 5, height}, std::pair{i + 7, width}}) {
      jpeg[at] = static_cast<std::byte>(value >> 8);
      jpeg[at + 1] = static_cast<std::byte>(value);
    }
    break;
  }
  return jpeg;
}

TEST(JpegTest, ALieAboutItsSizeCostsNoMemory) {
  PictureMaker maker;
  CameraData picture;
  const auto huge =
      maker.make(kJpegHead, resized(frames()[0], 65500, 65500), camera_mode::kRgb24, picture);
  ASSERT_FALSE(huge);
  EXPECT_EQ(huge.error().code(), tims::Errc::kTooBig);
  EXPECT_THAT(huge.error().detail(), testing::HasSubstr("65500x65500"));
  EXPECT_EQ(picture.image.capacity(), 0U);
  const auto large =
      maker.make(kJpegHead, resized(frames()[0], 1280, 1024), camera_mode::kRgb24, picture);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().code(), tims::Errc::kMalformed);
  for (const auto mode : {camera_mode::kJpeg, camera_mode::kRgb24})
    EXPECT_FALSE(maker.make(kJpegHead, resized(frames()[0], 0, 120), mode, picture));
}

// Repeated empty scans: each would take as long as a picture to decode.
TEST(JpegTest, AThousandScansAreNotDecoded) {
  const auto jpeg = [](std::initializer_list<std::initializer_list<int>> segments) {
    std::vector<std::byte> all;
    for (const auto& segment : segments)
      for (const int value : segment) all.push_back(static_cast<std::byte>(value));
    return all;
  };
  auto picture = jpeg({{0xFF, 0xD8},
                       {0xFF, 0xC2, 0, 11, 8, 0, 64, 0, 64, 1, 1, 0x11, 0},  // progressive, grey
                       {0xFF, 0xDB, 0, 67, 0}});
  picture.insert(picture.end(), 64, std::byte{1});
  const auto tables = jpeg({{0xFF, 0xC4, 0, 20, 0, 1}});
  picture.insert(picture.end(), tables.begin(), tables.end());
  picture.insert(picture.end(), 16, std::byte{0});
  const auto scan = jpeg({{0xFF, 0xDA, 0, 8, 1, 1, 0, 0, 0, 0}, std::initializer_list<int>{0}});
  for (int i = 0; i < 1000; ++i) picture.insert(picture.end(), scan.begin(), scan.end());
  picture.insert(picture.end(), {std::byte{0xFF}, std::byte{0xD9}});
  PictureMaker maker;
  CameraData data;
  const auto made = maker.make(kJpegHead, picture, camera_mode::kMono8, data);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().detail(), testing::HasSubstr("scans"));
}

TEST(PictureTest, ColoursOfYuv) {
  // Black, white; red and its neighbour (BT.601).
  const auto frame = bytes({16, 128, 235, 128, 81, 90, 81, 240});
  const VideoHead head{video::kYuyv, 2, 2, 4};
  PictureMaker maker;
  CameraData picture;
  ASSERT_TRUE(maker.make(head, frame, camera_mode::kRgb24, picture));
  const auto near = [&](std::size_t i, int value) {
    EXPECT_NEAR(std::to_integer<int>(picture.image[i]), value, 2) << i;
  };
  for (std::size_t i = 0; i < 3; ++i) near(i, 0);
  for (std::size_t i = 3; i < 6; ++i) near(i, 255);
  near(6, 255);
  near(7, 0);
  near(8, 0);
  ASSERT_TRUE(maker.make(head, frame, camera_mode::kMono8, picture));
  EXPECT_EQ(std::vector<std::byte>(picture.image), bytes({16, 235, 81, 81}));
  ASSERT_TRUE(maker.make(head, frame, camera_mode::kYuv422, picture));
  EXPECT_EQ(std::vector<std::byte>(picture.image), bytes({128, 16, 128, 235, 90, 81, 240, 81}));
}

TEST(PictureTest, LinesMayBeLongerThanTheirPixels) {
  const VideoHead head{video::kBgr24, 1, 2, 4};
  PictureMaker maker;
  CameraData picture;
  ASSERT_TRUE(maker.make(head, bytes({1, 2, 3, 99, 4, 5, 6}), camera_mode::kRgb24, picture));
  EXPECT_EQ(std::vector<std::byte>(picture.image), bytes({3, 2, 1, 6, 5, 4}));
  EXPECT_FALSE(maker.make(head, bytes({1, 2, 3, 99, 4, 5}), camera_mode::kRgb24, picture));
}

TEST(PictureTest, NumbersOf16BitsAreBigEndian) {
  const VideoHead head{video::kDepth16, 2, 1, 4};
  PictureMaker maker;
  CameraData picture;
  ASSERT_TRUE(maker.make(head, bytes({0xE8, 0x03, 0, 0}), camera_mode::kRange, picture));
  EXPECT_EQ(std::vector<std::byte>(picture.image), bytes({0x03, 0xE8, 0, 0}));
  EXPECT_EQ(picture.depth, 16);
  EXPECT_FALSE(maker.make(head, bytes({0, 0, 0, 0}), camera_mode::kRgb24, picture));
}

TEST(PictureTest, DepthDoesNotBecomeJpeg) {
  PictureMaker maker;
  CameraData picture;
  const auto made = maker.make({video::kDepth16, 8, 4, 16}, std::vector<std::byte>(64),
                               camera_mode::kJpeg, picture);
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().detail(), testing::HasSubstr("Z16  cannot be converted to mode jpeg"));
}

TEST(PictureTest, PixelsBecomeJpegAndComeBack) {
  PictureMaker maker(95);
  CameraData rgb{.width = 64, .height = 48, .depth = 24, .mode = camera_mode::kRgb24};
  for (int i = 0; i < 64 * 48; ++i)
    for (const int part : {i % 64 * 4, i / 64 * 5, 100})
      rgb.image.push_back(static_cast<std::byte>(part));
  CameraData jpeg;
  ASSERT_TRUE(maker.compress(rgb, jpeg));
  EXPECT_EQ(jpeg.mode, camera_mode::kJpeg);
  EXPECT_EQ(jpeg.width, 64);
  EXPECT_EQ(jpeg.colorFilterId, jpeg.image.size());
  EXPECT_LT(jpeg.image.size(), rgb.image.size() / 2);
  CameraData back;
  ASSERT_TRUE(maker.make(kJpegHead, jpeg.image, camera_mode::kRgb24, back));
  ASSERT_EQ(back.image.size(), rgb.image.size());
  double wrong = 0;
  for (std::size_t i = 0; i < rgb.image.size(); ++i)
    wrong += std::abs(std::to_integer<int>(back.image[i]) - std::to_integer<int>(rgb.image[i]));
  EXPECT_LT(wrong / static_cast<double>(rgb.image.size()), 4);
  rgb.mode = camera_mode::kRange;
  EXPECT_FALSE(maker.compress(rgb, jpeg));
}

// A scene of noise at two distances: its right half is nearer.
TEST(StereoTest, NearThingsAreFartherApart) {
  constexpr int kWidth = 120;
  constexpr int kHeight = 40;
  std::vector<std::byte> pair(std::size_t{2} * kWidth * kHeight);
  const auto at = [](int x, int y, int width) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  };
  const auto texture = [](int x, int y) {
    std::uint32_t hash =
        static_cast<std::uint32_t>(x) * 374761393U + static_cast<std::uint32_t>(y) * 668265263U;
    hash = (hash ^ hash >> 13) * 1274126177;
    return static_cast<std::byte>(hash >> 16 & 0xFF);
  };
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) pair[at(x, y, 2 * kWidth)] = texture(x, y);
    for (int x = 0; x < kWidth; ++x) {
      const int apart = x < 60 - 12 ? 5 : 12;
      pair[at(kWidth + x, y, 2 * kWidth)] = texture(x + apart, y);
    }
  }
  Stereo stereo({.disparities = 32, .block = 7});
  const auto found = stereo.match(pair, kWidth, kHeight);
  int right = 0;
  int seen = 0;
  for (int y = 5; y < kHeight - 5; ++y)
    for (const auto& [first, last, apart] : {std::array{12, 44, 5}, std::array{68, 112, 12}})
      for (int x = first; x < last; ++x) {
        const int disparity = found[at(x, y, kWidth)];
        seen += disparity != 0 ? 1 : 0;
        right += disparity != 0 && std::abs(disparity - 16 * apart) <= 8 ? 1 : 0;
      }
  EXPECT_GT(seen, 30 * 70);
  EXPECT_EQ(right, seen);
}

// The best match is outside of the right picture, at its left.
TEST(StereoTest, WhatOnlyOneEyeSeesIsNotKnown) {
  constexpr int kWidth = 12;
  constexpr int kHeight = 5;
  std::vector<std::byte> pair(std::size_t{2} * kWidth * kHeight);
  for (std::size_t y = 0; y < kHeight; ++y) {
    pair[y * 2 * kWidth + 2] = std::byte{255};
    pair[y * 2 * kWidth + kWidth] = std::byte{255};
    pair[y * 2 * kWidth + kWidth + 1] = std::byte{128};
  }
  Stereo stereo({.disparities = 8, .block = 3});
  const auto found = stereo.match(pair, kWidth, kHeight);
  for (std::size_t y = 0; y < kHeight; ++y) EXPECT_EQ(found[y * kWidth + 1], 0);
}

TEST(StereoTest, ABareWallIsNotKnown) {
  const std::vector<std::byte> pair(std::size_t{2} * 64 * 32, std::byte{100});
  Stereo stereo({});
  for (const std::uint16_t disparity : stereo.match(pair, 64, 32)) EXPECT_EQ(disparity, 0);
}

}  // namespace picture_test
}  // namespace rack::device
