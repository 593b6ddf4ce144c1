#include "rack/proxies/gdos.h"

#include <cstring>
#include <initializer_list>
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

std::string printed_and_decoded(std::string_view format,
                                std::initializer_list<Argument> arguments) {
  Body body{};
  const std::size_t size = encode(body, format, arguments);
  const auto decoded = decode(std::span(body).first(size), std::endian::native);
  return decoded ? *decoded : "malformed: " + decoded.error().detail();
}

TEST(Gdos, EveryConversionIsPrintedAndDecoded) {
  EXPECT_EQ(printed_and_decoded("Init", {}), "Init");
  EXPECT_EQ(printed_and_decoded("%d %i %u", {-7, 8, 9U}), "-7 8 9");
  EXPECT_EQ(printed_and_decoded("%x %X %b", {255, 0xABCU, 5}), "ff abc 101");
  EXPECT_EQ(printed_and_decoded("%n", {tims::Address(0x00180100)}), "Pilot(0/1)");
  EXPECT_EQ(printed_and_decoded("%f", {1.23456}), "1.235");
  EXPECT_EQ(printed_and_decoded("%a", {3.14159265}), "180.00");
  EXPECT_EQ(printed_and_decoded("%L", {std::int64_t{1} << 40}), "1099511627776");
  EXPECT_EQ(printed_and_decoded("%s, then %d and %s", {"first", 2, "third"s}),
            "first, then 2 and third");
  EXPECT_EQ(printed_and_decoded("100 %% of %d", {3}), "100 % of 3");
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

TEST(Gdos, LongTextsAreShortened) {
  const std::string name(300, 'x');
  const std::string text = printed_and_decoded("cannot open %s (%d)", {name, -2});
  EXPECT_TRUE(text.starts_with("cannot open xxx"));
  EXPECT_TRUE(text.ends_with("xxx (-2)")) << text;
  Body body{};
  const std::array<Argument, 2> arguments = {Argument(name), Argument(1)};
  EXPECT_EQ(encode(body, "%s%d", arguments), kBodyMax);
  EXPECT_LE(encode(body, std::string(300, 'y'), {}), kBodyMax);
}

TEST(Gdos, WrongArgumentsStopNobody) {
  EXPECT_EQ(printed_and_decoded("%d of %d", {1}), "1 of 0");
  EXPECT_EQ(printed_and_decoded("%s", {5}), "");
  EXPECT_EQ(printed_and_decoded("%d", {"text"}), "0");
  EXPECT_EQ(printed_and_decoded("none", {1, 2}), "none");
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
