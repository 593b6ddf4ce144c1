#include "components/pictures/pixels.h"

#include <gtest/gtest.h>

namespace rack::pictures {
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

// A patch of one colour has that colour, whatever the pattern: each pixel has one of the three.
TEST(Pixels, OfOneColourEachBecomePixelsOfAllColours) {
  constexpr std::array kRedGreenBlue = {std::byte{200}, std::byte{100}, std::byte{50}};
  struct Pattern {
    PixelLayout layout;
    std::array<std::size_t, 4> colours;  // 0 red, 1 green, 2 blue
  };
  for (const Pattern& pattern :
       {Pattern{PixelLayout::kRggb, {0, 1, 1, 2}}, Pattern{PixelLayout::kGbrg, {1, 2, 0, 1}},
        Pattern{PixelLayout::kGrbg, {1, 0, 2, 1}}, Pattern{PixelLayout::kBggr, {2, 1, 1, 0}}}) {
    constexpr std::size_t kSide = 8;
    std::vector<std::byte> raw(kSide * kSide);
    for (std::size_t y = 0; y < kSide; ++y)
      for (std::size_t x = 0; x < kSide; ++x)
        raw[y * kSide + x] = kRedGreenBlue.at(pattern.colours.at(y % 2 * 2 + x % 2));
    PixelConverter converter;
    std::vector<std::byte> rgb;
    const PixelView view{.layout = pattern.layout, .size = {kSide, kSide}, .bytes = raw};
    ASSERT_TRUE(converter.convert(view, PixelLayout::kRgb, rgb));
    for (std::size_t i = 0; i < rgb.size(); ++i) ASSERT_EQ(rgb[i], kRedGreenBlue.at(i % 3)) << i;
    ASSERT_TRUE(converter.convert(view, PixelLayout::kBgr, rgb));
    for (std::size_t i = 0; i < rgb.size(); ++i)
      ASSERT_EQ(rgb[i], kRedGreenBlue.at(2 - i % 3)) << i;
    std::vector<std::byte> grey;
    ASSERT_TRUE(converter.convert(view, PixelLayout::kGrey, grey));
    EXPECT_NEAR(std::to_integer<int>(grey[0]), 0.299 * 200 + 0.587 * 100 + 0.114 * 50, 1);
    ASSERT_TRUE(converter.convert(view, pattern.layout, grey));
    EXPECT_EQ(grey, raw);
    // Hardly any pixels: no colour, but no fault either.
    for (const PictureSize size : {PictureSize{1, 1}, {2, 2}, {1, 8}, {8, 1}, {3, 3}})
      ASSERT_TRUE(converter.convert({.layout = pattern.layout, .size = size, .bytes = raw},
                                    PixelLayout::kRgb, rgb));
  }
}

// The numbers of pixels are their places: y * 16 + x.
TEST(Pixels, AreThinnedInGroups) {
  std::vector<std::byte> raw(std::size_t{16} * 13);
  for (std::size_t i = 0; i < raw.size(); ++i) raw[i] = static_cast<std::byte>(i);
  const auto thin = [&](PixelLayout layout, PictureSize size, int n) {
    std::vector<std::byte> out;
    const auto view = thinned({.layout = layout, .size = size, .bytes = raw, .line_bytes = 16},
                              group_of(layout), n, out);
    std::vector<int> values;
    if (!view) return values;
    for (const std::byte one : view->bytes) values.push_back(std::to_integer<int>(one));
    EXPECT_EQ(values.size(), std::size_t{view->size.width} * view->size.height * bytes_of(layout));
    return values;
  };
  using Values = std::vector<int>;
  EXPECT_EQ(thin(PixelLayout::kGrey, {9, 5}, 4), (Values{0, 4}));
  EXPECT_EQ(thin(PixelLayout::kGrey, {8, 8}, 4), (Values{0, 4, 64, 68}));
  EXPECT_EQ(thin(PixelLayout::kUyvy, {8, 2}, 2), (Values{0, 1, 2, 3, 8, 9, 10, 11}));
  EXPECT_EQ(thin(PixelLayout::kRggb, {8, 4}, 2), (Values{0, 1, 4, 5, 16, 17, 20, 21}));
  EXPECT_EQ(thin(PixelLayout::kRgb, {4, 2}, 2), (Values{0, 1, 2, 6, 7, 8}));
  EXPECT_EQ(thin(PixelLayout::kBig16, {4, 1}, 2), (Values{}));  // no line is left
  EXPECT_EQ(thin(PixelLayout::kBig16, {4, 2}, 2), (Values{0, 1, 4, 5}));
  EXPECT_EQ(thin(PixelLayout::kGrey, {16, 13}, 0), (Values{}));
  EXPECT_EQ(thin(PixelLayout::kGrey, {16, 13}, 17), (Values{}));
  EXPECT_EQ(thin(PixelLayout::kGrey, {16, 13}, 13), (Values{0}));
  EXPECT_EQ(thin(PixelLayout::kGrey, {17, 13}, 2), (Values{})) << "fewer bytes than pixels";
}

TEST(Pixels, HaveSharesAndColours) {
  std::vector<std::byte> grey(100, std::byte{60});
  std::fill(grey.begin() + 75, grey.end(), std::byte{250});
  const PixelView view{.size = {10, 10}, .bytes = grey};
  EXPECT_DOUBLE_EQ(shares_of(view, 0, 1, 60, 250)->dark, 0.75);
  EXPECT_DOUBLE_EQ(shares_of(view, 0, 1, 60, 250)->bright, 0.25);
  EXPECT_DOUBLE_EQ(shares_of(view, 0, 1, 59, 251)->dark, 0);
  EXPECT_DOUBLE_EQ(shares_of(view, 0, 1, 59, 251)->bright, 0);
  EXPECT_DOUBLE_EQ(shares_of(view, 0, 2, 60, 250)->dark, 0.5);
  EXPECT_DOUBLE_EQ(shares_of(view, 0, 100, 60, 250)->bright, 1) << "one line";
  EXPECT_DOUBLE_EQ(shares_of(view, 0, 1, 255, 0)->dark, 1);
  EXPECT_DOUBLE_EQ(shares_of(view, 0, 1, -1, 256)->bright, 0);
  EXPECT_FALSE(shares_of(view, 0, 0, 60, 250));
  EXPECT_FALSE(colours_of(view, {0, 0, 10, 10})) << "grey";
  std::vector<std::byte> yuyv(80, std::byte{10});
  for (std::size_t i = 1; i < yuyv.size(); i += 4) yuyv[i] = std::byte{20};
  const PixelView pairs{.layout = PixelLayout::kYuyv, .size = {10, 4}, .bytes = yuyv};
  EXPECT_DOUBLE_EQ(colours_of(pairs, {2, 1, 8, 3})->u, 20);
  EXPECT_DOUBLE_EQ(colours_of(pairs, {2, 1, 8, 3})->v, 10);
  EXPECT_FALSE(colours_of(pairs, {3, 1, 8, 3}));
  EXPECT_FALSE(colours_of(pairs, {2, 2, 8, 3}));
  EXPECT_FALSE(colours_of(pairs, {2, 1, 1, 3}));
  EXPECT_FALSE(colours_of(pairs, {2, 1, 0xFFFFFFFF, 3}));
}

}  // namespace pixels_test
}  // namespace rack::pictures
