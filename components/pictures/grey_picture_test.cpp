#include "components/pictures/grey_picture.h"

#include <array>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::pictures {
namespace grey_picture_test {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::string_view kGrey8(
    "\x89\x50\x4E\x47\x0D\x0A\x1A\x0A\x00\x00\x00\x0D\x49\x48\x44\x52\x00\x00\x00\x03"
    "\x00\x00\x00\x02\x08\x00\x00\x00\x00\xB8\x1F\x39\xC6\x00\x00\x00\x10\x49\x44\x41"
    "\x54\x78\xDA\x63\xF8\xF7\x8F\x81\xE1\xEC\xBF\x7F\x00\x12\x4F\x04\xC6\x2E\x79\x39"
    "\xE9\x00\x00\x00\x00\x49\x45\x4E\x44\xAE\x42\x60\x82",
    73);
constexpr std::string_view kGrey16(
    "\x89\x50\x4E\x47\x0D\x0A\x1A\x0A\x00\x00\x00\x0D\x49\x48\x44\x52\x00\x00\x00\x02"
    "\x00\x00\x00\x01\x10\x00\x00\x00\x00\x81\xD9\xFC\x15\x00\x00\x00\x0D\x49\x44\x41"
    "\x54\x78\xDA\x63\xF8\xFF\x9F\x81\x11\x00\x06\xFF\x02\x00\x2E\xE7\x93\x17\x00\x00"
    "\x00\x00\x49\x45\x4E\x44\xAE\x42\x60\x82",
    70);
constexpr std::string_view kGrey1(
    "\x89\x50\x4E\x47\x0D\x0A\x1A\x0A\x00\x00\x00\x0D\x49\x48\x44\x52\x00\x00\x00\x04"
    "\x00\x00\x00\x01\x01\x00\x00\x00\x00\xD1\x47\x32\x60\x00\x00\x00\x0A\x49\x44\x41"
    "\x54\x78\xDA\x63\x58\x00\x00\x00\xA2\x00\xA1\x71\x05\xCB\x41\x00\x00\x00\x00\x49"
    "\x45\x4E\x44\xAE\x42\x60\x82",
    67);
constexpr std::string_view kPalette(
    "\x89\x50\x4E\x47\x0D\x0A\x1A\x0A\x00\x00\x00\x0D\x49\x48\x44\x52\x00\x00\x00\x04"
    "\x00\x00\x00\x01\x02\x03\x00\x00\x00\x84\x52\xE7\x5E\x00\x00\x00\x0C\x50\x4C\x54"
    "\x45\x00\x00\x00\xFF\xFF\xFF\x64\x64\x64\xCD\xCD\xCD\x81\xBE\x99\x83\x00\x00\x00"
    "\x0A\x49\x44\x41\x54\x78\xDA\x63\x90\x06\x00\x00\x1D\x00\x1C\x23\x7C\x8F\xAC\x00"
    "\x00\x00\x00\x49\x45\x4E\x44\xAE\x42\x60\x82",
    91);
constexpr std::string_view kColour(
    "\x89\x50\x4E\x47\x0D\x0A\x1A\x0A\x00\x00\x00\x0D\x49\x48\x44\x52\x00\x00\x00\x02"
    "\x00\x00\x00\x01\x08\x02\x00\x00\x00\x7B\x40\xE8\xDD\x00\x00\x00\x0F\x49\x44\x41"
    "\x54\x78\xDA\x63\xF8\xFF\xFF\x3F\x03\x03\x03\x00\x0E\xF8\x02\xFE\x70\xF0\x3F\xB2"
    "\x00\x00\x00\x00\x49\x45\x4E\x44\xAE\x42\x60\x82",
    72);
constexpr std::string_view kTransparent(
    "\x89\x50\x4E\x47\x0D\x0A\x1A\x0A\x00\x00\x00\x0D\x49\x48\x44\x52\x00\x00\x00\x02"
    "\x00\x00\x00\x01\x08\x06\x00\x00\x00\xF4\x22\x7F\x8A\x00\x00\x00\x10\x49\x44\x41"
    "\x54\x78\xDA\x63\xF8\xFF\xFF\x3F\x03\x10\xFC\x07\x00\x15\xF3\x03\xFD\xC7\x27\xAE"
    "\x60\x00\x00\x00\x00\x49\x45\x4E\x44\xAE\x42\x60\x82",
    73);

TEST(GreyPicture, IsAPgm) {
  for (const std::string_view pgm :
       {std::string_view("P5\n# made\n3 2\n255\n\xFE\xFE\x00\xCD\xFE\xFE", 24),
        std::string_view("P2 3 2 255\n254 254 0 205 254 254")}) {
    const auto picture = read_grey(pgm);
    ASSERT_TRUE(picture) << picture.error().detail();
    EXPECT_EQ(picture->width, 3);
    EXPECT_EQ(picture->height, 2);
    EXPECT_EQ(picture->white, 255);
    EXPECT_THAT(picture->values, ElementsAre(254, 254, 0, 205, 254, 254));
  }
}

// As GIMP, Netpbm, map_saver, ImageMagick and editors write it.
TEST(GreyPicture, HasAnyHead) {
  using std::string_literals::operator""s;
  const std::string pixels = "\xFE\xFE\x00\xCD\xFE\xFE"s;
  for (const std::string head :
       {"P5\n# Created by GIMP version 2.10.30 PNM plug-in\n3 2\n255\n", "P5 3 2 255\n",
        "P5\n# CREATOR: map_saver.cpp 0.050 m/pix\n3 2\n255\n", "P5\r\n3 2\r\n255\n",
        "P5\n3\n2\n255 ", "P5 # a\n#b\n3 # c\n# d\n2 #e\n 255\n", "P5\n\n3\t2\n\n255\n",
        "P5 003 002 00255\n"}) {
    const auto picture = read_grey(head + pixels);
    ASSERT_TRUE(picture) << head << picture.error().detail();
    EXPECT_THAT(picture->values, ElementsAre(254, 254, 0, 205, 254, 254)) << head;
  }
  for (const std::string text : {"P2\n# made by hand\n3 2\n255\n254 254 0\n205 254 254\n",
                                 "P2\r\n3 2\r\n255\r\n254 254 0\r\n205 254 254\r\n",
                                 "P2 3 2 255\n254\n254\n0\n205\n254\n254",
                                 "P2\n3 2\n255\n254 254 0 # first\n205 254 254 # second\n"}) {
    const auto picture = read_grey(text);
    ASSERT_TRUE(picture) << text << picture.error().detail();
    EXPECT_THAT(picture->values, ElementsAre(254, 254, 0, 205, 254, 254)) << text;
  }
}

// Values are not stretched: those of raw maps are per cent.
TEST(GreyPicture, HasAnyMaximum) {
  const auto small = read_grey("P2 3 1 100 100 0 37");
  ASSERT_TRUE(small);
  EXPECT_EQ(small->white, 100);
  EXPECT_THAT(small->values, ElementsAre(100, 0, 37));
  const auto binary = read_grey("P5 2 1 100 \x64\x25");
  ASSERT_TRUE(binary);
  EXPECT_EQ(binary->white, 100);
  EXPECT_THAT(binary->values, ElementsAre(100, 37));
  const auto large = read_grey(std::string_view("P5 2 1 1000\n\x03\xE8\x00\x01", 16));
  ASSERT_TRUE(large);
  EXPECT_EQ(large->white, 1000);
  EXPECT_THAT(large->values, ElementsAre(1000, 1));
  const auto text = read_grey("P2 2 1 65535 65535 300");
  ASSERT_TRUE(text);
  EXPECT_THAT(text->values, ElementsAre(65535, 300));
}

TEST(GreyPicture, ValuesOfTextsAreExact) {
  for (const int white : {1, 2, 3, 99, 100, 127, 254, 255, 256, 65535}) {
    std::string text =
        "P2 " + std::to_string(std::min(white, 255) + 1) + " 1 " + std::to_string(white);
    for (int i = 0; i <= std::min(white, 255); ++i) text += " " + std::to_string(i);
    const auto picture = read_grey(text);
    ASSERT_TRUE(picture) << white << ": " << picture.error().detail();
    for (std::size_t i = 0; i < picture->values.size(); ++i)
      ASSERT_EQ(picture->values[i], i) << "of " << white;
  }
}

TEST(GreyPicture, IsAPngOfAnyDepth) {
  const auto values = [](std::string_view png, std::uint16_t white) {
    const auto picture = read_grey(png);
    EXPECT_TRUE(picture) << picture.error().detail();
    EXPECT_EQ(picture->white, white);
    return picture->values;
  };
  EXPECT_THAT(values(kGrey8, 255), ElementsAre(254, 254, 0, 205, 254, 254));
  EXPECT_THAT(values(kGrey16, 65535), ElementsAre(65535, 1));
  EXPECT_THAT(values(kGrey1, 255), ElementsAre(255, 0, 255, 0));
  EXPECT_THAT(values(kPalette, 255), ElementsAre(0, 255, 100, 205));
  EXPECT_THAT(values(kColour, 255), ElementsAre(255, 0));
  EXPECT_THAT(values(kTransparent, 255), ElementsAre(255, 0));
}

TEST(GreyPicture, IsRefusedWhenItIsBroken) {
  for (const std::string_view pgm :
       {"", "P6 1 1 255 abc", "P5 0 1 255\n", "P5 -1 -1 255\n", "P5 2 2 255\nabc", "P5 2 2",
        "P2 2 1 255 3", "P2 2 1 255 3 x", "P5 1 1 70000\n1", "P5 1 1 0\n1", "P5 99999 99999 255\n",
        "P5 2147483647 2147483647 255\n", "P5 4294967297 1 255\n1"}) {
    const auto picture = read_grey(pgm);
    ASSERT_FALSE(picture) << pgm;
    EXPECT_EQ(picture.error().code(), tims::Errc::kMalformed) << pgm;
    EXPECT_FALSE(picture.error().detail().empty());
  }
}

TEST(GreyPicture, DamagedPngsBreakNothing) {
  for (const std::string_view png : {kGrey8, kGrey16, kGrey1, kPalette, kColour, kTransparent}) {
    for (std::size_t size = 0; size < png.size() - 24; ++size)
      EXPECT_FALSE(read_grey(png.substr(0, size))) << size;
    for (std::size_t bit = 0; bit < png.size() * 8; ++bit) {
      std::string damaged(png);
      damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ 1 << bit % 8);
      const auto picture = read_grey(damaged);
      if (!picture) continue;
      EXPECT_EQ(picture->values.size(), static_cast<std::size_t>(picture->width) *
                                            static_cast<std::size_t>(picture->height));
    }
  }
}

// The size is known before memory is allocated: at, below and above the limit.
TEST(GreyPicture, ItsSizeIsLimited) {
  const auto png = [](std::uint32_t width, std::uint32_t height) {
    std::string bytes(kGrey8);
    for (std::size_t i = 0; i < 4; ++i) {
      bytes[16 + i] = static_cast<char>(width >> (24 - 8 * i));
      bytes[20 + i] = static_cast<char>(height >> (24 - 8 * i));
    }
    return read_grey(bytes).error().detail();
  };
  EXPECT_THAT(png(12801, 10000), HasSubstr("more than 128000000 pixels"));
  EXPECT_THAT(png(0xFFFFFFFF, 0xFFFFFFFF), HasSubstr("more than 128000000 pixels"));
  EXPECT_THAT(png((1 << 20) + 1, 1), HasSubstr("more than 128000000 pixels"));
  EXPECT_THAT(png(0, 5), HasSubstr("no valid size"));
  EXPECT_THAT(png(1 << 20, 1), Not(HasSubstr("more than"))) << "damaged: its sum is another";
}

// Decoders of other formats are not open to files.
TEST(GreyPicture, OtherFormatsAreRefused) {
  for (const std::string_view other :
       {"II*\0", "BM", "\xFF\xD8\xFF\xE0", "RIFF", "GIF89a", "P4 1 1 a"})
    EXPECT_THAT(read_grey(other).error().detail(), HasSubstr("neither a PGM"));
}

// --- written

TEST(GreyPicture, IsWrittenWithTheseBytes) {
  const GreyPicture picture{.width = 3, .height = 2, .values = {254, 254, 0, 205, 254, 254}};
  const auto pgm = write_grey(picture, GreyFormat::kPgm);
  ASSERT_TRUE(pgm) << pgm.error().detail();
  EXPECT_EQ(*pgm, std::string_view("P5\n3 2\n255\n\xFE\xFE\x00\xCD\xFE\xFE", 17));
  const auto png = write_grey(picture, GreyFormat::kPng);
  ASSERT_TRUE(png) << png.error().detail();
  EXPECT_EQ(png->substr(0, 29), kGrey8.substr(0, 29)) << "grey, 8 bits, not interlaced";
  const auto deep =
      write_grey({.width = 2, .height = 1, .white = 65535, .values = {65535, 1}}, GreyFormat::kPgm);
  ASSERT_TRUE(deep) << deep.error().detail();
  EXPECT_EQ(*deep, std::string_view("P5\n2 1\n65535\n\xFF\xFF\x00\x01", 17));
}

TEST(GreyPicture, IsReadAsItWasWritten) {
  for (const std::uint16_t white : std::array<std::uint16_t, 2>{255, 65535}) {
    GreyPicture picture{.width = 16, .height = 17, .white = white};
    for (int i = 0; i < 16 * 17; ++i)
      picture.values.push_back(static_cast<std::uint16_t>(i * 7919 % (white + 1)));
    for (const GreyFormat format : {GreyFormat::kPgm, GreyFormat::kPng}) {
      const auto bytes = write_grey(picture, format);
      ASSERT_TRUE(bytes) << bytes.error().detail();
      const auto back = read_grey(*bytes);
      ASSERT_TRUE(back) << back.error().detail();
      EXPECT_EQ(back->width, 16);
      EXPECT_EQ(back->height, 17);
      EXPECT_EQ(back->white, white);
      EXPECT_EQ(back->values, picture.values);
    }
  }
}

TEST(GreyPicture, IsNotWrittenIfItIsNoFile) {
  const GreyPicture good{.width = 2, .height = 1, .values = {255, 0}};
  EXPECT_TRUE(write_grey(good, GreyFormat::kPng));
  const auto reason = [&](const std::function<void(GreyPicture&)>& change) {
    GreyPicture picture = good;
    change(picture);
    const auto written = write_grey(picture, GreyFormat::kPng);
    EXPECT_EQ(written.error().code(), tims::Errc::kInvalidArgument);
    return written ? "" : written.error().detail();
  };
  EXPECT_THAT(reason([](auto& picture) { picture.values[0] = 256; }), HasSubstr("above white"));
  EXPECT_THAT(reason([](auto& picture) { picture.white = 100; }), HasSubstr("255 or 65535"));
  EXPECT_THAT(reason([](auto& picture) { picture.values.pop_back(); }), HasSubstr("one value"));
  EXPECT_THAT(reason([](auto& picture) { picture.values.push_back(0); }), HasSubstr("one value"));
  EXPECT_THAT(reason([](auto& picture) { picture.width = 0; }), HasSubstr("no valid size"));
  EXPECT_THAT(reason([](auto& picture) { picture.width = picture.height = -1; }),
              HasSubstr("no valid size"));
}

TEST(GreyPicture, IsWrittenUpToAWidth) {
  for (const std::int32_t width : {kGreySideMax - 1, kGreySideMax, kGreySideMax + 1}) {
    GreyPicture picture{.width = width, .height = 1};
    picture.values.assign(static_cast<std::size_t>(width), 205);
    for (const GreyFormat format : {GreyFormat::kPgm, GreyFormat::kPng}) {
      const auto bytes = write_grey(picture, format);
      ASSERT_EQ(bytes.ok(), width <= kGreySideMax) << width << ": " << bytes.error().detail();
      if (bytes) {
        const auto back = read_grey(*bytes);
        ASSERT_TRUE(back) << back.error().detail();
        EXPECT_EQ(back->values, picture.values);
      } else {
        EXPECT_EQ(bytes.error().code(), tims::Errc::kTooBig);
      }
    }
  }
  const GreyPicture large{.width = 12801, .height = 10000};  // memory is not needed to refuse it
  EXPECT_EQ(write_grey(large, GreyFormat::kPgm).error().code(), tims::Errc::kTooBig);
}

}  // namespace grey_picture_test
}  // namespace rack::pictures
