#include "components/pictures/jpeg_frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "components/pictures/jpeg.h"

namespace rack::pictures {
namespace jpeg_frame_test {

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> all;
  for (const int value : values) all.push_back(static_cast<std::byte>(value));
  return all;
}

void append(std::vector<std::byte>& to, const std::vector<std::byte>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

std::vector<std::byte> scan() { return bytes({0xFF, 0xDA, 0, 8, 1, 1, 0, 0, 0x3F, 0}); }

// A grey picture with `scans` scans and `more` bytes of compressed pixels.
std::vector<std::byte> picture(int marker, int width, int height, int scans, std::size_t more) {
  auto jpeg = bytes({0xFF, 0xD8, 0xFF, marker, 0, 11, 8, height >> 8, height & 0xFF, width >> 8,
                     width & 0xFF, 1, 1, 0x11, 0});
  for (int i = 0; i < scans; ++i) append(jpeg, scan());
  jpeg.insert(jpeg.end(), more, std::byte{0x55});
  append(jpeg, bytes({0xFF, 0xD9}));
  return jpeg;
}

TEST(JpegFrame, HasASize) {
  const auto jpeg = picture(0xC0, 320, 200, 1, 1000);
  const auto size = jpeg_size(jpeg);
  ASSERT_TRUE(size);
  EXPECT_EQ(size->width, 320U);
  EXPECT_EQ(size->height, 200U);
  EXPECT_TRUE(check_jpeg(jpeg));
  EXPECT_FALSE(jpeg_size(std::span(jpeg).first(10)));
  EXPECT_FALSE(jpeg_size(picture(0xC0, 0, 200, 1, 1000)));
}

// A decoder skips markers without a length and would take the size behind them, which is far more
// than the one that follows their assumed length.
TEST(JpegFrame, CannotHaveASecondSizeBehindAMarkerWithoutLength) {
  for (const int marker : {0x00, 0x01, 0xD0, 0xD7, 0xD8, 0xD9}) {
    auto jpeg = bytes({0xFF, 0xD8, 0xFF, marker, 0, 13});
    append(jpeg, bytes({0xFF, 0xC0, 0, 11, 8, 0xFF, 0xDC, 0xFF, 0xDC, 1, 1}));
    const auto small = picture(0xC0, 8, 8, 1, 10);
    jpeg.insert(jpeg.end(), small.begin() + 2, small.end());
    EXPECT_FALSE(jpeg_size(jpeg)) << marker;
    EXPECT_FALSE(check_jpeg(jpeg)) << marker;
  }
}

TEST(JpegFrame, HasAsManyBytesAsItsSizeRequires) {
  // 40 x 25 blocks: 2 bits each in a baseline picture, 1 in a progressive one.
  for (const auto& [marker, needed] : {std::pair{0xC0, 250U}, std::pair{0xC2, 125U}}) {
    const std::size_t others = picture(marker, 320, 200, 1, 0).size();
    EXPECT_TRUE(check_jpeg(picture(marker, 320, 200, 1, needed - others)));
    const auto few = check_jpeg(picture(marker, 320, 200, 1, needed - others - 1));
    ASSERT_FALSE(few);
    EXPECT_THAT(few.error().detail(), testing::HasSubstr("cannot be 320x200 pixels"));
  }
}

TEST(JpegFrame, HasNotTooManyScans) {
  EXPECT_FALSE(check_jpeg(picture(0xC2, 64, 64, 0, 1000)));
  EXPECT_TRUE(check_jpeg(picture(0xC2, 64, 64, 1, 1000)));
  EXPECT_TRUE(check_jpeg(picture(0xC2, 64, 64, kJpegScansMax, 1000)));
  const auto many = check_jpeg(picture(0xC2, 64, 64, kJpegScansMax + 1, 1000));
  ASSERT_FALSE(many);
  EXPECT_THAT(many.error().detail(), testing::HasSubstr("51 scans"));
}

TEST(JpegFrame, IsOfAKindThatCamerasSend) {
  for (const int marker : {0xC0, 0xC1, 0xC2})
    EXPECT_TRUE(check_jpeg(picture(marker, 64, 64, 1, 1000))) << marker;
  for (const int marker : {0xC3, 0xC9, 0xCA, 0xCF})
    EXPECT_FALSE(check_jpeg(picture(marker, 64, 64, 1, 1000))) << marker;
}

TEST(JpegFrame, HasAnEnd) {
  auto jpeg = picture(0xC0, 64, 64, 1, 1000);
  jpeg.pop_back();
  const auto cut = check_jpeg(jpeg);
  ASSERT_FALSE(cut);
  EXPECT_THAT(cut.error().detail(), testing::HasSubstr("its end is missing"));
  std::vector<std::byte> whole;
  EXPECT_FALSE(complete_jpeg(jpeg, {}, whole));
}

TEST(JpegFrame, GetsTheTablesItLacks) {
  const auto jpeg = picture(0xC0, 64, 64, 1, 100);
  const auto tables = bytes({0xFF, 0xC4, 0, 3, 9});
  std::vector<std::byte> whole;
  ASSERT_TRUE(complete_jpeg(jpeg, tables, whole));
  ASSERT_EQ(whole.size(), jpeg.size() + tables.size());
  EXPECT_EQ(huffman_tables(whole), tables);
  std::vector<std::byte> again;
  ASSERT_TRUE(complete_jpeg(whole, bytes({0xFF, 0xC4, 0, 3, 7}), again));
  EXPECT_EQ(again, whole);
}

// Turned cameras note the orientation beside the picture, which does not turn it here.
TEST(JpegFrame, IsNotTurned) {
  Jpeg library;
  std::vector<std::byte> jpeg;
  const std::vector<std::byte> pixels(std::size_t{32} * 8, std::byte{90});
  ASSERT_TRUE(library.encode({.layout = PixelLayout::kGrey, .size = {32, 8}, .bytes = pixels}, 90,
                             10000, jpeg));
  auto turned =
      bytes({0xFF, 0xD8, 0xFF, 0xE1, 0,  34, 'E', 'x', 'i', 'f', 0, 0, 'M', 'M', 0, 42, 0, 0, 0,
             8,    0,    1,    1,    18, 0,  3,   0,   0,   0,   1, 0, 6,   0,   0, 0,  0, 0, 0});
  turned.insert(turned.end(), jpeg.begin() + 2, jpeg.end());
  std::vector<std::byte> back;
  const auto size = library.decode(turned, PixelLayout::kGrey, 10000, back);
  ASSERT_TRUE(size) << size.error().message();
  EXPECT_EQ(size->width, 32U);
  EXPECT_EQ(back.size(), pixels.size());
}

// The limits of messages: at, below and above.
TEST(JpegFrame, DecodesAndEncodesUpToALimit) {
  Jpeg library;
  std::vector<std::byte> jpeg;
  const std::vector<std::byte> pixels(std::size_t{32} * 8, std::byte{90});
  const PixelView view{.layout = PixelLayout::kGrey, .size = {32, 8}, .bytes = pixels};
  ASSERT_TRUE(library.encode(view, 90, 10000, jpeg));
  const std::size_t size = jpeg.size();
  EXPECT_TRUE(library.encode(view, 90, size, jpeg));
  const auto large = library.encode(view, 90, size - 1, jpeg);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().code(), tims::Errc::kTooBig);
  ASSERT_TRUE(library.encode(view, 90, size, jpeg));
  std::vector<std::byte> back;
  EXPECT_TRUE(library.decode(jpeg, PixelLayout::kBgr, std::size_t{32} * 8 * 3, back));
  const auto many = library.decode(jpeg, PixelLayout::kBgr, std::size_t{32} * 8 * 3 - 1, back);
  ASSERT_FALSE(many);
  EXPECT_EQ(many.error().code(), tims::Errc::kTooBig);
}

}  // namespace jpeg_frame_test
}  // namespace rack::pictures
