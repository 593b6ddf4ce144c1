#include "components/devices/camera/picture.h"

#include <array>
#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
  EXPECT_NEAR(std::to_integer<int>(yuv.image[1]), std::to_integer<int>(grey.image[0]), 1);
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
  EXPECT_THAT(large.error().detail(), testing::HasSubstr("cannot be 1280x1024 pixels"));
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
  near(6, 0);
  near(7, 0);
  near(8, 255);
  ASSERT_TRUE(maker.make(head, frame, camera_mode::kMono8, picture));
  EXPECT_EQ(std::vector<std::byte>(picture.image), bytes({16, 235, 81, 81}));
  ASSERT_TRUE(maker.make(head, frame, camera_mode::kYuv422, picture));
  EXPECT_EQ(std::vector<std::byte>(picture.image), bytes({128, 16, 128, 235, 90, 81, 240, 81}));
}

// The original's driver, its CameraJpeg and its window agree on B G R. One red pixel.
TEST(PictureTest, Rgb24IsBlueGreenRed) {
  PictureMaker maker(95);
  CameraData picture;
  const auto red = bytes({0, 0, 255});
  for (const auto& [format, frame] :
       {std::pair{video::kRgb24, bytes({255, 0, 0})}, std::pair{video::kBgr24, red}}) {
    ASSERT_TRUE(maker.make({format, 1, 1, 0}, frame, camera_mode::kRgb24, picture));
    EXPECT_EQ(std::vector<std::byte>(picture.image), red) << letters_of(format);
  }
  EXPECT_EQ(pixels_of(picture)->layout, pictures::PixelLayout::kBgr);
  // Red stays red on the way to JPEG and back.
  CameraData wide{.width = 16, .height = 16, .mode = camera_mode::kRgb24};
  for (int i = 0; i < 256; ++i) wide.image.insert(wide.image.end(), red.begin(), red.end());
  CameraData jpeg;
  ASSERT_TRUE(maker.compress(wide, jpeg));
  CameraData back;
  ASSERT_TRUE(maker.make(kJpegHead, jpeg.image, camera_mode::kRgb24, back));
  EXPECT_LT(std::to_integer<int>(back.image[0]), 8);
  EXPECT_GT(std::to_integer<int>(back.image[2]), 247);
  pictures::Jpeg decoder;
  std::vector<std::byte> pixels;
  ASSERT_TRUE(decoder.decode(jpeg.image, pictures::PixelLayout::kBgr, kCameraBytesMax, pixels));
  EXPECT_GT(std::to_integer<int>(pixels[2]), 247);
}

TEST(PictureTest, LinesMayBeLongerThanTheirPixels) {
  const VideoHead head{video::kBgr24, 1, 2, 4};
  PictureMaker maker;
  CameraData picture;
  ASSERT_TRUE(maker.make(head, bytes({1, 2, 3, 99, 4, 5, 6}), camera_mode::kRgb24, picture));
  EXPECT_EQ(std::vector<std::byte>(picture.image), bytes({1, 2, 3, 4, 5, 6}));
  EXPECT_FALSE(maker.make(head, bytes({1, 2, 3, 99, 4, 5}), camera_mode::kRgb24, picture));
}

TEST(PictureTest, ColoursOfPairsNeedAnEvenWidth) {
  PictureMaker maker;
  CameraData picture;
  const std::vector<std::byte> frame(12);
  for (const auto mode : {camera_mode::kRgb24, camera_mode::kYuv422, camera_mode::kJpeg}) {
    EXPECT_TRUE(maker.make({video::kYuyv, 2, 2, 6}, frame, mode, picture));
    const auto odd = maker.make({video::kYuyv, 3, 2, 6}, frame, mode, picture);
    ASSERT_FALSE(odd);
    EXPECT_EQ(odd.error().code(), tims::Errc::kMalformed);
    EXPECT_THAT(odd.error().detail(), testing::HasSubstr("odd width"));
  }
}

// The sizes that a message can have, and that the format can have.
TEST(PictureTest, ItsSizeIsLimited) {
  PictureMaker maker;
  CameraData picture;
  std::vector<std::byte> frame(kCameraBytesMax + std::size_t{3} * 1280);
  EXPECT_TRUE(maker.make({video::kRgb24, 1280, 1024, 0}, frame, camera_mode::kRgb24, picture));
  EXPECT_EQ(picture.image.size(), kCameraBytesMax);
  const auto large =
      maker.make({video::kRgb24, 1280, 1025, 0}, frame, camera_mode::kRgb24, picture);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().code(), tims::Errc::kTooBig);
  EXPECT_TRUE(maker.make({video::kGrey, 0xFFFF, 2, 0}, frame, camera_mode::kMono8, picture));
  EXPECT_FALSE(maker.make({video::kGrey, 0x10000, 2, 0}, frame, camera_mode::kMono8, picture));
  EXPECT_TRUE(maker.make({video::kGrey, 65500, 2, 0}, frame, camera_mode::kJpeg, picture));
  EXPECT_FALSE(maker.make({video::kGrey, 65501, 2, 0}, frame, camera_mode::kJpeg, picture));
  EXPECT_FALSE(maker.make({video::kGrey, 0, 2, 0}, frame, camera_mode::kMono8, picture));
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

// Answers of the conversions that OpenCV replaced. OpenCV computes with more bits and rounds to the
// nearest value; the old code cut. Values of YUV below 16 (Y) are black for OpenCV and were
// extrapolated by the old code: such pixels are left out here.
TEST(PictureTest, KnownAnswersOfYuyv) {
  struct Answer {
    std::array<int, 4> yuyv;
    std::array<int, 6> rgb;
  };
  constexpr std::array kAnswers = {Answer{{60, 94, 129, 180}, {134, 22, 0, 215, 103, 63}},
                                   Answer{{151, 214, 60, 251}, {255, 24, 255, 248, 0, 225}},
                                   Answer{{220, 83, 174, 136}, {250, 249, 147, 197, 195, 93}},
                                   Answer{{55, 26, 18, 81}, {0, 123, 0, 0, 80, 0}},
                                   Answer{{33, 181, 149, 97}, {0, 24, 127, 105, 159, 255}},
                                   Answer{{67, 192, 238, 45}, {0, 102, 188, 126, 255, 255}},
                                   Answer{{85, 251, 99, 140}, {99, 23, 255, 116, 39, 255}},
                                   Answer{{119, 254, 224, 182}, {206, 27, 255, 255, 149, 255}},
                                   Answer{{245, 249, 39, 95}, {214, 246, 255, 0, 6, 255}},
                                   Answer{{175, 41, 126, 44}, {51, 255, 10, 0, 230, 0}}};
  PictureMaker maker;
  CameraData picture;
  for (const auto& [yuyv, rgb] : kAnswers) {
    const auto [y0, u, y1, v] = yuyv;
    for (const auto& [format, frame] : {std::pair{video::kYuyv, bytes({y0, u, y1, v})},
                                        std::pair{video::kUyvy, bytes({u, y0, v, y1})}}) {
      ASSERT_TRUE(maker.make({format, 2, 1, 4}, frame, camera_mode::kRgb24, picture));
      for (std::size_t i = 0; i < rgb.size(); ++i)
        EXPECT_NEAR(std::to_integer<int>(picture.image[i / 3 * 3 + 2 - i % 3]), rgb.at(i), 1)
            << y0 << " " << u;
    }
  }
}

TEST(PictureTest, KnownAnswersOfGrey) {
  struct Answer {
    std::array<int, 3> rgb;
    int grey;
  };
  constexpr std::array kAnswers = {
      Answer{{151, 223, 84}, 185}, Answer{{4, 243, 59}, 150},    Answer{{212, 6, 98}, 78},
      Answer{{11, 88, 33}, 58},    Answer{{207, 104, 37}, 127},  Answer{{156, 203, 238}, 192},
      Answer{{2, 7, 255}, 33},     Answer{{205, 116, 100}, 140}, Answer{{171, 247, 187}, 217},
      Answer{{125, 106, 37}, 103}, Answer{{230, 191, 162}, 199}, Answer{{148, 137, 13}, 126}};
  PictureMaker maker;
  CameraData picture;
  for (const auto& [rgb, grey] : kAnswers) {
    const auto [r, g, b] = rgb;
    ASSERT_TRUE(
        maker.make({video::kRgb24, 1, 1, 3}, bytes({r, g, b}), camera_mode::kMono8, picture));
    EXPECT_NEAR(std::to_integer<int>(picture.image[0]), grey, 1);
    ASSERT_TRUE(
        maker.make({video::kBgr24, 1, 1, 3}, bytes({b, g, r}), camera_mode::kMono8, picture));
    EXPECT_NEAR(std::to_integer<int>(picture.image[0]), grey, 1);
  }
}

// Pixels of a camera's frame as the old code decoded them. OpenCV uses the exact transform of
// libjpeg instead of the fast one, and computes YUV back from RGB.
TEST(JpegTest, KnownAnswersOfACamera) {
  struct Answer {
    std::size_t x;
    std::size_t y;
    std::array<int, 3> rgb;
    int grey;
  };
  constexpr std::array kAnswers = {
      Answer{10, 10, {57, 51, 25}, 50},      Answer{80, 60, {77, 81, 46}, 76},
      Answer{150, 100, {121, 122, 91}, 118}, Answer{40, 90, {72, 74, 37}, 69},
      Answer{120, 20, {49, 49, 41}, 48},     Answer{66, 110, {66, 67, 35}, 63}};
  constexpr std::array kPairs = {std::array{114, 50, 133, 47},   std::array{110, 76, 128, 76},
                                 std::array{113, 118, 130, 125}, std::array{110, 69, 130, 68},
                                 std::array{123, 48, 129, 46},   std::array{112, 63, 130, 62}};
  constexpr int kTolerance = 3;
  PictureMaker maker;
  CameraData rgb;
  CameraData grey;
  CameraData yuv;
  const auto frame = frames()[0];
  ASSERT_TRUE(maker.make(kJpegHead, frame, camera_mode::kRgb24, rgb));
  ASSERT_TRUE(maker.make(kJpegHead, frame, camera_mode::kMono8, grey));
  ASSERT_TRUE(maker.make(kJpegHead, frame, camera_mode::kYuv422, yuv));
  for (std::size_t i = 0; i < kAnswers.size(); ++i) {
    const auto& answer = kAnswers.at(i);
    const std::size_t at = answer.y * 160 + answer.x;
    EXPECT_NEAR(std::to_integer<int>(grey.image[at]), answer.grey, kTolerance);
    for (std::size_t part = 0; part < 3; ++part)
      EXPECT_NEAR(std::to_integer<int>(rgb.image[3 * at + 2 - part]), answer.rgb.at(part),
                  kTolerance);
    for (std::size_t part = 0; part < 4; ++part)
      EXPECT_NEAR(std::to_integer<int>(yuv.image[2 * at + part]), kPairs.at(i).at(part),
                  kTolerance);
  }
  EXPECT_NEAR(*brightness_of(rgb, 1), 100, 1);
  EXPECT_NEAR(*brightness_of(grey, 1), 96, 1);
  EXPECT_NEAR(*brightness_of(yuv, 1), 96, 1);
}

TEST(RawTest, PixelsOfOneColourEachPassAsTheyAre) {
  PictureMaker maker;
  CameraData picture;
  const auto raw = bytes({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16});
  struct Case {
    std::uint32_t format;
    u16 mode;
    u32 filter;
    std::vector<std::byte> image;
  };
  for (const Case& one :
       {Case{video::kRggb, camera_mode::kRaw8, bayer::kRggb, bytes({1, 2, 5, 6})},
        Case{video::kGbrg, camera_mode::kRaw8, bayer::kGbrg, bytes({1, 2, 5, 6})},
        Case{video::kBggr, camera_mode::kRaw8, bayer::kBggr, bytes({1, 2, 5, 6})},
        Case{video::kGrbg16, camera_mode::kRaw12, bayer::kGrbg, bytes({2, 1, 4, 3, 10, 9, 12, 11})},
        Case{video::kGrbg16 | video::kBigEndian, camera_mode::kRaw16, bayer::kGrbg,
             bytes({1, 2, 3, 4, 9, 10, 11, 12})},
        Case{video::kGrey16 | video::kBigEndian, camera_mode::kMono12, 0,
             bytes({1, 2, 3, 4, 9, 10, 11, 12})}}) {
    const bool is_wide = one.image.size() == 8;
    const VideoHead head{one.format, is_wide ? 4U : 2U, 2, is_wide ? 8U : 4U};
    const auto made = maker.make(head, raw, one.mode, picture);
    ASSERT_TRUE(made) << letters_of(one.format) << made.error().message();
    EXPECT_EQ(picture.colorFilterId, one.filter);
    EXPECT_EQ(picture.depth, is_wide ? 16 : 8);
    const std::size_t line = is_wide ? 4 : 2;
    ASSERT_EQ(picture.image.size(), is_wide ? 16U : 4U);
    EXPECT_TRUE(
        std::ranges::equal(std::span(picture.image).first(line), std::span(one.image).first(line)))
        << letters_of(one.format);
  }
  EXPECT_EQ(letters_of(video::kGrey16 | video::kBigEndian), "Y16 -BE");
}

TEST(RawTest, OtherModesAreRefusedOrConverted) {
  PictureMaker maker;
  CameraData picture;
  const std::vector<std::byte> raw(64, std::byte{80});
  const VideoHead raw8{video::kRggb, 8, 8, 8};
  ASSERT_TRUE(maker.make(raw8, raw, camera_mode::kRgb24, picture));
  EXPECT_EQ(picture.image.size(), 192U);
  EXPECT_EQ(picture.colorFilterId, 0U);
  ASSERT_TRUE(maker.make(raw8, raw, camera_mode::kJpeg, picture));
  ASSERT_TRUE(maker.make(raw8, raw, camera_mode::kMono8, picture));
  const VideoHead raw16{video::kRggb16, 4, 8, 8};
  for (const auto& [head, mode] :
       {std::pair{raw8, camera_mode::kRaw12}, std::pair{raw8, camera_mode::kYuv422},
        std::pair{raw16, camera_mode::kRaw8}, std::pair{raw16, camera_mode::kRgb24},
        std::pair{raw16, camera_mode::kMono16}, std::pair{raw16, camera_mode::kJpeg},
        std::pair{VideoHead{video::kGrey, 8, 8, 8}, camera_mode::kRaw8},
        std::pair{VideoHead{video::kGrey | video::kBigEndian, 8, 8, 8}, camera_mode::kMono8},
        std::pair{VideoHead{video::kGrey16, 4, 8, 8}, camera_mode::kRaw16}}) {
    const auto made = maker.make(head, raw, mode, picture);
    ASSERT_FALSE(made) << letters_of(head.format) << " " << mode;
    EXPECT_EQ(made.error().code(), tims::Errc::kInvalidArgument);
  }
}

TEST(RawTest, APictureIsThinnedBeforeItIsConverted) {
  PictureMaker maker;
  CameraData picture;
  const std::vector<std::byte> raw(64, std::byte{80});
  ASSERT_TRUE(maker.make({video::kUyvy, 8, 4, 16}, raw, camera_mode::kYuv422, picture, 2));
  EXPECT_EQ(picture.width, 4);
  EXPECT_EQ(picture.height, 2);
  // Squares also of 16 bits: the colours of neighbours differ.
  ASSERT_TRUE(maker.make({video::kRggb16, 8, 4, 16}, raw, camera_mode::kRaw16, picture, 2));
  EXPECT_EQ(picture.width, 4);
  EXPECT_EQ(picture.height, 2);
  EXPECT_FALSE(maker.make({video::kRggb16, 8, 4, 16}, raw, camera_mode::kRaw16, picture, 3));
}

}  // namespace picture_test
}  // namespace rack::device
