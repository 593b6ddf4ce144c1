#include "components/devices/camera/pixels.h"

#include <gtest/gtest.h>

namespace rack::device {
namespace pixels_test {

TEST(Pixels, AreAsManyAsTheSizeRequires) {
  const std::vector<std::byte> bytes(100);
  const auto is_whole = [&](std::uint32_t width, std::uint32_t height, std::size_t line,
                            std::size_t size) {
    return PixelView{.layout = PixelLayout::kRgb,
                     .size = {width, height},
                     .bytes = std::span(bytes).first(size),
                     .line_bytes = line}
        .is_whole();
  };
  EXPECT_TRUE(is_whole(5, 2, 0, 30));
  EXPECT_FALSE(is_whole(5, 2, 0, 29));
  EXPECT_TRUE(is_whole(5, 2, 20, 35)) << "the last line needs no padding";
  EXPECT_FALSE(is_whole(5, 2, 20, 34));
  EXPECT_TRUE(is_whole(5, 2, 7, 30)) << "lines are not shorter than their pixels";
  EXPECT_FALSE(is_whole(0, 2, 0, 100));
  EXPECT_FALSE(is_whole(5, 0, 0, 100));
  EXPECT_FALSE(is_whole(0xFFFFFFFF, 0xFFFFFFFF, 0, 100));
}

TEST(Pixels, KnowTheirConversions) {
  EXPECT_TRUE(PixelConverter::can_convert(PixelLayout::kBgr, PixelLayout::kUyvy));
  EXPECT_FALSE(PixelConverter::can_convert(PixelLayout::kGrey, PixelLayout::kUyvy));
  PixelConverter converter;
  std::vector<std::byte> out;
  const std::vector<std::byte> bytes(100);
  const auto none = converter.convert(
      {.layout = PixelLayout::kGrey, .size = {4, 4}, .bytes = bytes}, PixelLayout::kUyvy, out);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code(), tims::Errc::kInvalidArgument);
}

// The result is in the caller's memory, also when that is larger.
TEST(Pixels, StayInTheCallersMemory) {
  PixelConverter converter;
  std::vector<std::byte> out(1000);
  const std::byte* const memory = out.data();
  const std::vector<std::byte> bytes(100);
  for (const auto& [from, to] : {std::pair{PixelLayout::kYuyv, PixelLayout::kRgb},
                                 std::pair{PixelLayout::kYuyv, PixelLayout::kUyvy},
                                 std::pair{PixelLayout::kUyvy, PixelLayout::kGrey},
                                 std::pair{PixelLayout::kBgr, PixelLayout::kUyvy},
                                 std::pair{PixelLayout::kGrey, PixelLayout::kGrey}}) {
    ASSERT_TRUE(converter.convert({.layout = from, .size = {4, 4}, .bytes = bytes}, to, out));
    EXPECT_EQ(out.data(), memory);
    EXPECT_EQ(out.size(), 16 * bytes_of(to));
  }
}

TEST(Pixels, TheMeanIsOfTheMiddle) {
  std::vector<std::byte> grey(std::size_t{8} * 8, std::byte{10});
  for (const std::size_t y : {2U, 3U, 4U, 5U})
    for (const std::size_t x : {2U, 3U, 4U, 5U}) grey[8 * y + x] = std::byte{50};
  const PixelView view{.layout = PixelLayout::kGrey, .size = {8, 8}, .bytes = grey};
  EXPECT_DOUBLE_EQ(*mean_of(view, 0, 1), 20);
  EXPECT_DOUBLE_EQ(*mean_of(view, 0, 2), 50);
  EXPECT_DOUBLE_EQ(*mean_of(view, 0, 1000), 50) << "one pixel";
  EXPECT_FALSE(mean_of(view, 0, 0));
  EXPECT_FALSE(mean_of({.size = {9, 8}, .bytes = grey}, 0, 1));
}

// 1 + 200 / 64 = 4: of each four lines one.
TEST(Pixels, TheMeanIsOfSomeLines) {
  std::vector<std::byte> grey(200);
  for (std::size_t y = 0; y < grey.size(); y += 4) grey[y] = std::byte{80};
  EXPECT_DOUBLE_EQ(*mean_of({.size = {1, 200}, .bytes = grey}, 0, 1), 80);
}

}  // namespace pixels_test
}  // namespace rack::device
