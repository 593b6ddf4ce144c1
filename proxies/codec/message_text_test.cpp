#include "rack/codec/message_text.h"

#include <limits>

#include <gtest/gtest.h>

#include "proxies/codec/sample_fixture.h"

namespace rack {
namespace message_text_test {

using test::Sample;
using test::to_json;
using test::to_text;

// --- output

Sample sample() {
  return {.recordingTime = 7,
          .pos = {.x = -5, .rho = 0.1F},
          .sender = tims::Address(0x00180100),
          .name = "a\"b",
          .pair = {1.5, std::numeric_limits<f64>::quiet_NaN()},
          .levels = {3, -4},
          .imageSize = 2,
          .points = {{.x = 1, .rho = 2}, {.x = 3, .rho = 4}},
          .image = {std::byte{0x0A}, std::byte{0xFF}}};
}

TEST(Print, Json) {
  EXPECT_EQ(
      to_json(sample()),
      R"~({"recordingTime":7,"pos":{"x":-5,"rho":0.1},"sender":"Pilot(0/1)","name":"a\"b",)~"
      R"~("pair":[1.5,null],"levels":[3,-4],"imageSize":2,"pointNum":2,"points":[{"x":1,"rho":2},{"x":3,"rho":4}],)~"
      R"~("image":"0aff"})~");
}

TEST(Print, JsonOfTheFirstElements) {
  EXPECT_TRUE(
      to_json(sample(), {.elements_max = 1})
          .ends_with(
              R"("pair":[1.5,null],"levels":[3,-4],"imageSize":2,"pointNum":2,"points":[{"x":1,"rho":2}],"image":"0a"})"));
}

TEST(Print, TextWithUnits) {
  EXPECT_EQ(to_text(sample()),
            "recordingTime: 7 ms\n"
            "pos.x: -5 mm\n"
            "pos.rho: 0.1 rad\n"
            "sender: Pilot(0/1)\n"
            "name: \"a\\\"b\"\n"
            "pair: 1.5 nan\n"
            "levels: 3 -4\n"
            "imageSize: 2\n"
            "pointNum: 2\n"
            "points[0]: x 1 mm, rho 2 rad\n"
            "points[1]: x 3 mm, rho 4 rad\n"
            "image: \"0aff\"\n");
}

TEST(Print, TextSaysWhatItLeavesOut) {
  EXPECT_TRUE(to_text(sample(), {.elements_max = 1})
                  .ends_with("points[0]: x 1 mm, rho 2 rad\n"
                             "points: 1 more\n"
                             "image: \"0a\"\n"));
}

TEST(Print, OneLine) {
  EXPECT_EQ(to_text(sample(), {.elements_max = 1, .one_line = true}),
            "recordingTime 7 ms, pos.x -5 mm, pos.rho 0.1 rad, sender Pilot(0/1), name \"a\\\"b\", "
            "pair 1.5 nan, levels 3 -4, imageSize 2, pointNum 2, points[0] (x 1 mm, rho 2 rad), "
            "points 1 more, "
            "image \"0a\"");
}

TEST(Print, InSiUnits) {
  Sample s = sample();
  s.pos.x = 1001;
  EXPECT_TRUE(to_text(s, {.si = true})
                  .starts_with("recordingTime: 0.007 s\npos.x: 1.001 m\npos.rho: 0.1 rad\n"));
  EXPECT_TRUE(to_json(s, {.si = true})
                  .starts_with(R"({"recordingTime":0.007,"pos":{"x":1.001,"rho":0.1},)"));
}

TEST(Print, WhatIsNoNumberIsCalledByItsName) {
  Sample s = sample();
  s.pos.rho = std::numeric_limits<f32>::infinity();
  s.sender = kNobody;
  const std::string text = to_text(s);
  EXPECT_NE(text.find("pos.rho: inf rad\nsender: none\n"), std::string::npos) << text;
  const std::string json = to_json(s);
  EXPECT_NE(json.find(R"("rho":null},"sender":null,)"), std::string::npos) << json;
}

TEST(Print, AddressesAreDividedAsTheFleetDoes) {
  constexpr tims::AddressWidths kWidths{6, 8, 10, 8};
  Sample s = sample();
  s.sender = tims::Address::of({.system = 3, .class_id = 0x14, .instance = 500}, kWidths);
  EXPECT_NE(to_text(s, {.widths = kWidths}).find("sender: Ladar(3/500)\n"), std::string::npos);
}

TEST(Print, Columns) {
  const std::vector<Column> expected = {{"recordingTime", "ms", "s", "u32"},
                                        {"pos.x", "mm", "m", "i32"},
                                        {"pos.rho", "rad", "rad", "f32"},
                                        {"sender", "", "", "address"},
                                        {"name", "", "", "text"},
                                        {"pair[0]", "", "", "f64"},
                                        {"pair[1]", "", "", "f64"},
                                        {"levels[0]", "", "", "i8"},
                                        {"levels[1]", "", "", "i8"},
                                        {"imageSize", "", "", "u8"},
                                        {"pointNum", "", "", "count"},
                                        {"points[].x", "mm", "m", "i32"},
                                        {"points[].rho", "rad", "rad", "f32"},
                                        {"image[]", "", "", "byte"}};
  EXPECT_EQ(columns_of(kSchema<Sample>), expected);
}

TEST(Print, HostileTextsStayWithinTheirQuotes) {
  std::string out;
  append_quoted(out, "\x1B[31m\n\xFF\\");
  EXPECT_EQ(out, "\"\\u001b[31m\\u000a\\u00ff\\\\\"");
}

struct Extremes {
  f32 a = 0.1F;
  f64 b = std::numeric_limits<f64>::max();
  i64 c = std::numeric_limits<i64>::min();
  std::uint64_t d = std::numeric_limits<std::uint64_t>::max();
};

TEST(Print, NumbersReadBackTheSame) {
  EXPECT_EQ(to_text(kSchema<Extremes>, made_value(kSchema<Extremes>), {.one_line = true}),
            "a 0.1, b 1.7976931348623157e+308, c -9223372036854775808, d 18446744073709551615");
}

TEST(Print, NumbersOfARecording) {
  const auto value = read_value(kSchema<Sample>, test::body_of(sample()), std::endian::native);
  ASSERT_TRUE(value);
  EXPECT_EQ(
      to_numbers(kSchema<Sample>, *value),
      "7 -5 0.100000 1573120 \"a\\\"b\" 1.5000000000000000 nan 3 -4 2 2 1 2.000000 3 4.000000 "
      "\"0aff\"");
}

// --- input

std::string set(Sample& order, std::string_view field, std::string_view value, bool si = false) {
  auto made = read_value(kSchema<Sample>, test::body_of(order), std::endian::native);
  EXPECT_TRUE(made);
  const auto done = assign(kSchema<Sample>, *made, {field, value}, {.si = si});
  if (done && field == "image") {
    const std::string size = std::to_string(value.size() / 2);
    EXPECT_TRUE(assign(kSchema<Sample>, *made, {"imageSize", size}));
  }
  const auto body = write_value(kSchema<Sample>, *made, std::endian::native);
  EXPECT_TRUE(body && decode<Sample>(*body, std::endian::native, order));
  return done ? "" : done.error().detail();
}

TEST(Parse, NumbersInTheUnitsOfTheWire) {
  Sample order;
  EXPECT_EQ(set(order, "recordingTime", "7"), "");
  EXPECT_EQ(set(order, "pos.x", "-5"), "");
  EXPECT_EQ(set(order, "pos.rho", "0.5"), "");
  EXPECT_EQ(set(order, "levels[1]", "-128"), "");
  EXPECT_EQ(order.recordingTime, TimeStamp(7));
  EXPECT_EQ(order.pos.x, -5);
  EXPECT_EQ(order.pos.rho, 0.5F);
  EXPECT_EQ(order.levels[1], -128);
}

TEST(Parse, NumbersWithUnitsAndInSi) {
  Sample order;
  EXPECT_EQ(set(order, "pos.x", "200mm"), "");
  EXPECT_EQ(order.pos.x, 200);
  EXPECT_EQ(set(order, "pos.x", "0.25 m"), "");
  EXPECT_EQ(order.pos.x, 250);
  EXPECT_EQ(set(order, "pos.x", "-1.5", true), "");
  EXPECT_EQ(order.pos.x, -1500);
  EXPECT_EQ(set(order, "pos.x", "30mm", true), "");
  EXPECT_EQ(order.pos.x, 30);
  EXPECT_EQ(set(order, "recordingTime", "1.5s"), "");
  EXPECT_EQ(order.recordingTime, TimeStamp(1500));
}

TEST(Parse, TextsAddressesBytes) {
  Sample order;
  EXPECT_EQ(set(order, "name", "1234567"), "");
  EXPECT_EQ(order.name, "1234567");
  EXPECT_EQ(set(order, "sender", "Pilot(0/1)"), "");
  EXPECT_EQ(order.sender, tims::Address(0x00180100));
  EXPECT_EQ(set(order, "sender", "none"), "");
  EXPECT_EQ(order.sender, kNobody);
  EXPECT_EQ(set(order, "image", "0aff"), "");
  EXPECT_EQ(order.image.size(), 2U);
  EXPECT_EQ(order.image[1], std::byte{255});
}

TEST(Parse, SequencesGrowInTheirOrder) {
  Sample order;
  EXPECT_NE(set(order, "points[1].x", "1"), "");
  EXPECT_EQ(set(order, "points[0].x", "1"), "");
  EXPECT_EQ(set(order, "points[0].rho", "2"), "");
  EXPECT_EQ(set(order, "points[1].x", "3"), "");
  EXPECT_EQ(set(order, "points[2].x", "4"), "");
  EXPECT_NE(set(order, "points[3].x", "5"), "") << "3 fit";
  ASSERT_EQ(order.points.size(), 3U);
  EXPECT_EQ(order.points[0].rho, 2.0F);
  EXPECT_EQ(order.points[1].x, 3);
}

TEST(Parse, RefusesWhatIsNotMeantAndLeavesTheMessageAlone) {
  Sample order{.pos = {.x = 1}, .name = "a", .levels = {3, 4}};
  EXPECT_EQ(set(order, "vz", "1"), "Sample has no field \"vz\"");
  EXPECT_EQ(set(order, "pos.z", "1"), "Pose has no field \"z\"");
  EXPECT_EQ(set(order, "pos.x.y", "1"), "i32 has no field \".y\"");
  EXPECT_EQ(set(order, "pos.x", "fast"), "pos.x=fast: expected a number in mm");
  EXPECT_EQ(set(order, "pos.x", ""),
            "pos.x=: expected a whole number from -2147483648 to 2147483647");
  EXPECT_EQ(set(order, "pos.x", "1.5"),
            "pos.x=1.5: expected a whole number from -2147483648 to 2147483647");
  EXPECT_EQ(set(order, "pos.x", "1rad"), "pos.x=1rad: expected a number in mm");
  EXPECT_EQ(set(order, "pos.x", "2147483647"), "");
  EXPECT_EQ(set(order, "pos.x", "2147483648"),
            "pos.x=2147483648: expected a whole number from -2147483648 to 2147483647");
  EXPECT_EQ(set(order, "pos.x", "2147484m"),
            "pos.x=2147484m: expected a whole number from -2147483648 to 2147483647");
  EXPECT_EQ(set(order, "levels[0]", "128"),
            "levels[0]=128: expected a whole number from -128 to 127");
  EXPECT_NE(set(order, "levels[2]", "1"), "");
  EXPECT_NE(set(order, "levels", "1"), "");
  EXPECT_NE(set(order, "pos", "1"), "");
  EXPECT_NE(set(order, "pointNum", "1"), "");
  EXPECT_NE(set(order, "points[0].z", "1"), "");
  EXPECT_NE(set(order, "name", "12345678"), "") << "7 fit";
  EXPECT_NE(set(order, "sender", "somebody"), "");
  EXPECT_NE(set(order, "image", "0"), "");
  EXPECT_NE(set(order, "image", "0102030405"), "") << "4 fit";
  EXPECT_NE(set(order, "", "1"), "");
  EXPECT_NE(set(order, "[", "1"), "");
  EXPECT_EQ(order.pos.x, 2147483647);
  EXPECT_EQ(order.name, "a");
  EXPECT_EQ(order.levels[0], 3);
  EXPECT_TRUE(order.points.empty());
}

TEST(Parse, WhatIsPrintedCanBeRead) {
  Sample order{.recordingTime = 1, .pos = {.x = 2, .rho = 0.1F}, .levels = {5, 6}};
  Sample again;
  for (const std::string_view field : {"pos.x", "pos.rho"}) {
    const std::string text = to_text(order, {.si = true});
    const std::size_t at = text.find(std::string(field) + ": ") + field.size() + 2;
    EXPECT_EQ(set(again, field, text.substr(at, text.find('\n', at) - at)), "");
  }
  EXPECT_EQ(again.pos.x, order.pos.x);
  EXPECT_EQ(again.pos.rho, order.pos.rho);
}

}  // namespace message_text_test
}  // namespace rack
