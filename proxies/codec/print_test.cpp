#include "rack/codec/print.h"

#include <limits>

#include <gtest/gtest.h>

#include "proxies/codec/sample_fixture.h"

namespace rack {
namespace {

using test::Sample;

Sample sample() {
  return {.recordingTime = 7,
          .pos = {.x = -5, .rho = 0.1F},
          .who = tims::Address(0x00180100),
          .name = "a\"b",
          .pair = {1.5, std::numeric_limits<f64>::quiet_NaN()},
          .levels = {3, -4},
          .points = {{.x = 1, .rho = 2}, {.x = 3, .rho = 4}},
          .image = {std::byte{0x0A}, std::byte{0xFF}}};
}

TEST(Print, Json) {
  EXPECT_EQ(
      to_json(sample()),
      R"~({"recordingTime":7,"pos":{"x":-5,"rho":0.1},"who":"Pilot(0/1)","name":"a\"b",)~"
      R"~("pair":[1.5,null],"levels":[3,-4],"pointNum":2,"points":[{"x":1,"rho":2},{"x":3,"rho":4}],)~"
      R"~("image":"0aff"})~");
}

TEST(Print, JsonOfTheFirstElements) {
  EXPECT_TRUE(
      to_json(sample(), {.elements_max = 1})
          .ends_with(
              R"("pair":[1.5,null],"levels":[3,-4],"pointNum":2,"points":[{"x":1,"rho":2}],"image":"0a"})"));
}

TEST(Print, TextWithUnits) {
  EXPECT_EQ(to_text(sample()),
            "recordingTime: 7 ms\n"
            "pos.x: -5 mm\n"
            "pos.rho: 0.1 rad\n"
            "who: Pilot(0/1)\n"
            "name: \"a\\\"b\"\n"
            "pair: 1.5 nan\n"
            "levels: 3 -4\n"
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
            "recordingTime 7 ms, pos.x -5 mm, pos.rho 0.1 rad, who Pilot(0/1), name \"a\\\"b\", "
            "pair 1.5 nan, levels 3 -4, pointNum 2, points[0] (x 1 mm, rho 2 rad), points 1 more, "
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
  s.who = kNobody;
  const std::string text = to_text(s);
  EXPECT_NE(text.find("pos.rho: inf rad\nwho: none\n"), std::string::npos) << text;
  const std::string json = to_json(s);
  EXPECT_NE(json.find(R"("rho":null},"who":null,)"), std::string::npos) << json;
}

TEST(Print, AddressesAreDividedAsTheFleetDoes) {
  constexpr tims::AddressWidths kWidths{6, 8, 10, 8};
  Sample s = sample();
  s.who = tims::Address::of({.system = 3, .class_id = 0x14, .instance = 500}, kWidths);
  EXPECT_NE(to_text(s, {.widths = kWidths}).find("who: Ladar(3/500)\n"), std::string::npos);
}

TEST(Print, Columns) {
  const std::vector<Column> expected = {{"recordingTime", "ms", "s", "u32"},
                                        {"pos.x", "mm", "m", "i32"},
                                        {"pos.rho", "rad", "rad", "f32"},
                                        {"who", "", "", "address"},
                                        {"name", "", "", "text"},
                                        {"pair[0]", "", "", "f64"},
                                        {"pair[1]", "", "", "f64"},
                                        {"levels[0]", "", "", "i8"},
                                        {"levels[1]", "", "", "i8"},
                                        {"pointNum", "", "", "count"},
                                        {"points[].x", "mm", "m", "i32"},
                                        {"points[].rho", "rad", "rad", "f32"},
                                        {"image[]", "", "", "byte"}};
  EXPECT_EQ(columns<Sample>(), expected);
}

TEST(Print, HostileTextsStayWithinTheirQuotes) {
  std::string out;
  print::append_quoted(out, "\x1B[31m\n\xFF\\");
  EXPECT_EQ(out, "\"\\u001b[31m\\u000a\\u00ff\\\\\"");
}

TEST(Print, NumbersReadBackTheSame) {
  std::string out;
  print::append(out, 0.1F);
  out += ' ';
  print::append(out, std::numeric_limits<double>::max());
  out += ' ';
  print::append(out, std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(out, "0.1 1.7976931348623157e+308 -9223372036854775808");
}

}  // namespace
}  // namespace rack
