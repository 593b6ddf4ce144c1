#include "rack/proxies/gdos.h"

#include <vector>

#include <gtest/gtest.h>

#include "rack/codec/codec.h"

namespace rack::gdos {
namespace gdos_test {

using namespace std::string_literals;

// A body as written by a sender with the given byte order.
class Made {
 public:
  explicit Made(const std::string& format, std::endian order = std::endian::native)
      : order_(order) {
    raw(format + '\0');
  }
  Made& raw(const std::string& text) {
    for (const char c : text) bytes_.push_back(static_cast<std::byte>(c));
    return *this;
  }
  template <typename T>
  Made& number(T value) {
    std::byte to[sizeof value];
    (void)bytes::write(to, order_, value);
    bytes_.insert(bytes_.end(), std::begin(to), std::end(to));
    return *this;
  }
  [[nodiscard]] std::string text() const {
    const auto decoded = decode(bytes_, order_);
    return decoded ? *decoded : "malformed: " + decoded.error().detail();
  }

 private:
  std::endian order_;
  std::vector<std::byte> bytes_;
};

// The bytes that are sent, without the NUL.
std::string sent(std::string_view text) {
  Body body{};
  body.fill(std::byte{0x55});
  const std::size_t size = encode(body, text);
  EXPECT_LE(size, kBodyMax);
  EXPECT_EQ(body.at(size - 1), std::byte{0});
  return {reinterpret_cast<const char*>(body.data()), size - 1};
}
std::string sent_and_decoded(std::string_view text) {
  Body body{};
  const std::size_t size = encode(body, text);
  const auto decoded = decode(std::span(body).first(size), std::endian::native);
  return decoded ? *decoded : "malformed: " + decoded.error().detail();
}

TEST(Gdos, EveryConversionOfTheOriginalIsDecoded) {
  EXPECT_EQ(Made("Init").text(), "Init");
  EXPECT_EQ(Made("%d %i %u").number(-7).number(8).number(9).text(), "-7 8 9");
  EXPECT_EQ(Made("%x %X %b").number(255).number(0xABC).number(5).text(), "ff abc 101");
  EXPECT_EQ(Made("%n").number<std::uint32_t>(0x00180100).text(), "Pilot(0/1)");
  EXPECT_EQ(Made("%f").number(1.23456).text(), "1.235");
  EXPECT_EQ(Made("%a").number(3.14159265).text(), "180.00");
  EXPECT_EQ(Made("%L").number(std::int64_t{1} << 40).text(), "1099511627776");
  EXPECT_EQ(Made("%s, then %d and %s").raw("first\0"s).number(2).raw("third\0"s).text(),
            "first, then 2 and third");
  EXPECT_EQ(Made("100 %% of %d").number(3).text(), "100 % of 3");
}

TEST(Gdos, FromEitherByteOrder) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    EXPECT_EQ(Made("Listener %n (datambx: %x)", order)
                  .number<std::uint32_t>(0x00130000)
                  .number<std::uint32_t>(0x130002)
                  .text(),
              "Listener Position(0/0) (datambx: 130002)");
    EXPECT_EQ(Made("%f m at %a", order).number(2.5).number(-0.5).text(), "2.500 m at -28.65");
  }
}

TEST(Gdos, PointersOf32And64Bits) {
  EXPECT_EQ(Made("at %p, %d").number<std::uint32_t>(0x1000).number<std::int32_t>(7).text(),
            "at 0x1000, 7");
  EXPECT_EQ(Made("at %p, %d").number<std::uint64_t>(0x7f0000001000).number<std::int32_t>(7).text(),
            "at 0x7f0000001000, 7");
}

// C programs of the original overwrite the NUL of a text with the next argument and send one byte
// too many.
TEST(Gdos, TextsWithoutTheirEnd) {
  EXPECT_EQ(Made("file %s: error %d").raw("map.dxf").number<std::int32_t>(-2).raw("\x7F").text(),
            "file map.dxf: error -2");
  EXPECT_EQ(Made("file %s: error %d").raw("map.dxf\0"s).number<std::int32_t>(-2).text(),
            "file map.dxf: error -2");
}

TEST(Gdos, PlainTextsOfJavaPrograms) {
  const std::string text = "Joystick lost";
  const auto decoded = decode(std::as_bytes(std::span(text)), std::endian::big);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(*decoded, text);
}

TEST(Gdos, OneLine) {
  EXPECT_EQ(Made("a\r\nb\x1B[31m %s\n").raw("c\nd\0"s).text(), "a  b [31m c d");
}

TEST(Gdos, WhatIsMissingIsMalformed) {
  EXPECT_EQ(Made("speed %d").raw("ab").text(), "malformed: speed %d");
  EXPECT_EQ(Made("name %s").raw("endless").text(), "malformed: name %s");
  EXPECT_EQ(Made("odd %q").text(), "malformed: odd %q");
  EXPECT_EQ(Made("left over").raw("x").text(), "malformed: left over");
  EXPECT_TRUE(decode({}, std::endian::little));
}

// The programs of the original format what they receive; a conversion without its argument stops
// the text window of their graphical interface.
TEST(Gdos, ATextThatIsSentHasNoConversions) {
  EXPECT_EQ(sent("Init"), "Init");
  EXPECT_EQ(sent("100 % of %d, %s"), "100 %% of %%d, %%s");
  EXPECT_EQ(sent("%"), "%%");
  EXPECT_EQ(sent("%%"), "%%%%");
  EXPECT_EQ(sent(""), "");
  for (const char* text : {"", "Init", "100 % of %d", "%", "%%", "{}", "Käfer"})
    EXPECT_EQ(sent_and_decoded(text), text);
}

TEST(Gdos, ATextThatIsSentIsOneLine) {
  EXPECT_EQ(sent("a\r\nb\x1B[31m\x7F!\n \n"), "a  b [31m !");
  EXPECT_EQ(sent("a\0b"s), "a b") << "behind a NUL would be arguments";
  EXPECT_EQ(sent("\u009B31m"), "  31m") << "control sequence introducer";
  EXPECT_EQ(sent(" \n"), "");
  EXPECT_EQ(sent("K\xE4"
                 "fer"),
            "K\xE4"
            "fer")
      << "as the original programs write";
}

TEST(Gdos, ALongTextIsCutBetweenCharacters) {
  EXPECT_EQ(sent(std::string(254, 'y')), std::string(254, 'y'));
  EXPECT_EQ(sent(std::string(255, 'y')), std::string(255, 'y'));
  EXPECT_EQ(sent(std::string(256, 'y')), std::string(255, 'y'));
  EXPECT_EQ(sent(std::string(253, 'y') + "ä"), std::string(253, 'y') + "ä");
  EXPECT_EQ(sent(std::string(254, 'y') + "äz"), std::string(254, 'y'));
  EXPECT_EQ(sent(std::string(251, 'y') + "\U0001F916"), std::string(251, 'y') + "\U0001F916");
  EXPECT_EQ(sent(std::string(252, 'y') + "\U0001F916"), std::string(252, 'y'));
  EXPECT_EQ(sent(std::string(253, 'y') + "%"), std::string(253, 'y') + "%%");
  EXPECT_EQ(sent(std::string(254, 'y') + "%"), std::string(254, 'y'));
  EXPECT_EQ(sent_and_decoded(std::string(300, '%')), std::string(127, '%'));
}

TEST(Gdos, Levels) {
  EXPECT_EQ(level_of(std::int8_t{-125}), Level::kError);
  EXPECT_FALSE(level_of(std::int8_t{-123}));
  EXPECT_EQ(level_of_parameter(2), Level::kWarning);
  for (const Level level : {Level::kPrint, Level::kDetail}) EXPECT_EQ(level_of(name(level)), level);
  EXPECT_FALSE(level_of("loud"));
}

}  // namespace gdos_test
}  // namespace rack::gdos
