#include "components/localisation/ros_yaml.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rack::localisation {

namespace ros_yaml_test {

RosMapInfo read(std::string_view text) {
  const auto info = read_ros_yaml(text);
  EXPECT_TRUE(info.ok()) << info.error().detail();
  return info ? *info : RosMapInfo{};
}

std::string error_of(std::string_view text) {
  const auto info = read_ros_yaml(text);
  return info ? "it was read" : info.error().detail();
}

TEST(RosYaml, ReadsADescription) {
  const RosMapInfo info = read(
      "image: \"a map.pgm\"  # beside\nresolution: 0.1\norigin: [-1.5, 2.0, 0.0]\nnegate: 0\n"
      "occupied_thresh: 0.7\nfree_thresh: 0.25\n");
  EXPECT_EQ(info.image, "a map.pgm");
  EXPECT_DOUBLE_EQ(info.resolution, 0.1);
  EXPECT_DOUBLE_EQ(info.origin_x, -1.5);
  EXPECT_DOUBLE_EQ(info.origin_y, 2.0);
  EXPECT_DOUBLE_EQ(info.occupied_thresh, 0.7);
  EXPECT_DOUBLE_EQ(info.free_thresh, 0.25);
  EXPECT_FALSE(info.negate);
  EXPECT_FALSE(info.is_raw);
}

// As programs write it: lists a number a line, quotes, carriage returns, other modes.
TEST(RosYaml, ReadsWhatOthersWrite) {
  const RosMapInfo info = read(
      "---\r\n# made\r\nimage: '/maps/a b.pgm'\r\nmode: \"scale\"\r\nresolution: 5e-2\r\n"
      "origin:\r\n  - -12.5  # x\r\n  - +3\r\n  - 0.0\r\nnegate: false\r\n...\r\n");
  EXPECT_EQ(info.image, "/maps/a b.pgm");
  EXPECT_DOUBLE_EQ(info.origin_x, -12.5);
  EXPECT_DOUBLE_EQ(info.origin_y, 3);
  EXPECT_TRUE(read("image: a\nresolution: 1\nnegate: yes\nmode: raw\n").negate);
  EXPECT_TRUE(read("image: a\nresolution: 1\nnegate: 1\nmode: raw\n").is_raw);
}

TEST(RosYaml, AListHasAnyForm) {
  for (const std::string_view origin :
       {"origin: [0.1, -2, 0]\n", "origin:\n- 0.1\n- -2\n- 0\n",
        "origin:\n    - 0.1\n    - -2\n    - 0\n", "origin:\n  [0.1,\n   -2,\n   0]\n",
        "origin:\n  -\n    0.1\n  - -2.0 # y\n\n  - 0e0\n", "\"origin\": [ 0.1 ,-2,0, ]\n"}) {
    const RosMapInfo info = read("image: a\n" + std::string(origin) + "resolution: 1\n");
    EXPECT_DOUBLE_EQ(info.origin_x, 0.1) << origin;
    EXPECT_DOUBLE_EQ(info.origin_y, -2) << origin;
  }
}

// Marks of editors, quotes around anything, every kind of line end, and every form of yes.
TEST(RosYaml, ReadsWhatEditorsLeaveBehind) {
  const std::string text = "image: 'map.pgm'\nresolution: \"0.050000\"\norigin: [\"-1\", '2', 0]\n";
  for (const std::string& read_text : {text, "\xEF\xBB\xBF" + text, "\xEF\xBB\xBF---\n" + text}) {
    const RosMapInfo info = read(read_text);
    EXPECT_DOUBLE_EQ(info.resolution, 0.05);
    EXPECT_DOUBLE_EQ(info.origin_x, -1);
    EXPECT_DOUBLE_EQ(info.origin_y, 2);
    EXPECT_EQ(info.image, "map.pgm");
  }
  for (const char* yes : {"1", "true", "True", "TRUE", "yes", "on", "y", "\"1\"", "'true'", "2"})
    EXPECT_TRUE(read(text + "negate: " + yes + "\n").negate) << yes;
  for (const char* no : {"0", "false", "False", "no", "off", "n", "\"0\"", "0.0"})
    EXPECT_FALSE(read(text + "negate: " + no + "\n").negate) << no;
  for (const char* small : {"0.05 # m", ".05", "5e-2", "5.0000000000000003e-02", "+0.05", "0.05  "})
    EXPECT_DOUBLE_EQ(read("image: a\nresolution: " + std::string(small) + "\n").resolution, 0.05);
  EXPECT_DOUBLE_EQ(read("{image: a, resolution: 0.05, origin: [1, 2, -0.0]}").origin_x, 1);
}

// As in map_server, what is strange but clear is read. It is reported.
TEST(RosYaml, RemarksOnWhatIsStrange) {
  const RosMapInfo twice = read("image: a\nresolution: 1\nresolution: 2\n");
  EXPECT_DOUBLE_EQ(twice.resolution, 1);
  EXPECT_THAT(twice.remarks,
              testing::ElementsAre("line 3: resolution is there twice; the first is used"));
  const RosMapInfo exchanged =
      read("image: a\nresolution: 1\noccupied_thresh: 0.1\nfree_thresh: 0.65\n");
  EXPECT_DOUBLE_EQ(exchanged.occupied_thresh, 0.1);
  EXPECT_THAT(exchanged.remarks,
              testing::ElementsAre(testing::HasSubstr("occupied_thresh 0.1 is less than")));
}

// Other programs' keys.
TEST(RosYaml, IgnoresUnknownKeys) {
  EXPECT_EQ(read("image: a\nresolution: 1\nsize:\n- 1\nnote: {by: [me, you]}\n").image, "a");
}

TEST(RosYaml, ReportsWhatIsWrong) {
  EXPECT_EQ(error_of("just text\n"), "line 1: expected `key: value`");
  EXPECT_EQ(error_of("\n- image\n"), "line 2: expected `key: value`");
  EXPECT_EQ(error_of("? [a]\n: b\n"), "line 1: expected `key: value`");
  EXPECT_EQ(error_of("resolution: fine\n"), "line 1: resolution: not a number");
  EXPECT_EQ(error_of("image: a\nresolution: [1]\n"), "line 2: resolution: not a number");
  EXPECT_EQ(error_of("image: a\n\norigin: [1, 2]\n"), "line 3: origin: must be [x, y, theta]");
  EXPECT_DOUBLE_EQ(read("image: a\nresolution: 1\norigin: [1, 2, 1e-7]\n").origin_y, 2);
  EXPECT_EQ(error_of("origin: [1, 2, 0.5]\n"),
            "line 1: origin: rotated maps are not supported; rotate the image");
  EXPECT_EQ(error_of("origin: here\n"), "line 1: origin: must be [x, y, theta]");
  EXPECT_EQ(error_of("origin:\n- 1\n- 2\nimage: a\n"), "line 2: origin: must be [x, y, theta]");
  EXPECT_EQ(error_of("origin:\n- 1\n- x\n- 0\n"),
            "line 2: origin: must be [x, y, theta]; y is \"x\", which is not a number");
  for (const std::string theta : {"-nan", "nan", "NaN", ".nan", "inf", "\"-nan\""})
    EXPECT_THAT(error_of("origin: [1, 2, " + theta + "]\n"),
                testing::AllOf(testing::HasSubstr("theta is \""),
                               testing::HasSubstr("not a number: write 0 for a map that")));
  EXPECT_EQ(error_of("image: ~/a.pgm\n"),
            "line 1: image: ~ is not replaced by a folder: write the whole path, or the path from "
            "this file");
  EXPECT_EQ(error_of("origin:\n- 1\n- 2\n- 0\n- 4\n"), "line 2: origin: must be [x, y, theta]");
  EXPECT_EQ(error_of("mode: grey\n"), "line 1: mode: must be trinary, scale or raw");
  EXPECT_EQ(error_of("negate: maybe\n"), "line 1: negate: must be 0 or 1, or true or false");
  EXPECT_EQ(error_of("image: [a]\n"), "line 1: image: must be the name of a file");
  EXPECT_EQ(error_of("resolution: 0.1\n"), "no `image: FILE`");
  EXPECT_EQ(error_of(""), "no `image: FILE`");
  EXPECT_EQ(error_of("image: a\nresolution: nan\n"), "line 2: resolution: not a number");
  EXPECT_EQ(error_of("image: a\nresolution: .inf\n"), "line 2: resolution: not a number");
}

// The message is yaml-cpp's, the line number ours.
TEST(RosYaml, WhatIsNoYamlIsReportedWithItsLine) {
  for (const std::string_view text :
       {"image: a\nresolution 5\nnegate: 0\n", "image: a\norigin: [1, 2\nmode: raw\n",
        "image: a\n\tresolution: 1\n", "a: &b 1\nimage: *c\n", "image: a: b\n", "}",
        "image: \"\\q\"\n"}) {
    const std::string error = error_of(text);
    EXPECT_EQ(error.find("line "), 0U) << text << ": " << error;
    EXPECT_GT(error.size(), 10U);
  }
}

TEST(RosYaml, HasLimits) {
  const std::string start = "image: a\nresolution: ";
  EXPECT_EQ(read(start + "0.001").resolution, 0.001);
  EXPECT_EQ(read(start + "10").resolution, 10);
  for (const char* resolution : {"0.00099", "10.01", "0", "-1", "1e300"})
    EXPECT_EQ(error_of(start + resolution), "no `resolution: METRES` between 0.001 and 10");
  EXPECT_EQ(error_of("image: a\n"), "no `resolution: METRES` between 0.001 and 10");
  EXPECT_EQ(read(start + "1\norigin: [1e6, -1e6, 0]").origin_x, 1e6);
  EXPECT_EQ(error_of(start + "1\norigin: [0, -1.1e6, 0]"), "origin: more than 1000 km away");
  const std::string most = start + "1\n#";
  EXPECT_EQ(read(most + std::string(kRosYamlMax - most.size(), 'x')).image, "a");
  EXPECT_EQ(error_of(most + std::string(kRosYamlMax - most.size() + 1, 'x')),
            "more than 64 KiB: this is not the description of a map");
}

// Some bytes that ask for much.
TEST(RosYaml, IsBoundedInTimeAndDepth) {
  EXPECT_EQ(error_of(std::string(kRosYamlMax, '[')).find("line 1: "), 0U);
  EXPECT_EQ(error_of(std::string(kRosYamlMax, '{')).find("line 1: "), 0U);
  std::string deep;
  for (int i = 0; i < 30'000; ++i) deep += "- ";
  EXPECT_FALSE(read_ros_yaml(deep).ok());
  std::string laughs = "a: &a [1, 2]\n";
  for (char c = 'b'; c <= 'z'; ++c)
    laughs += fmt::format("{0}: &{0} [*{1}, *{1}, *{1}, *{1}]\n", c, static_cast<char>(c - 1));
  EXPECT_EQ(read(laughs + "image: a\nresolution: 1\n").image, "a");
  EXPECT_EQ(error_of("origin: &o [*o, *o, *o]\n").find("line 1: "), 0U) << "in itself";
}

TEST(RosYaml, ThereAndBack) {
  const GridMap map{.resolution = 50, .origin = {-2500, 1230}, .rows = 1, .columns = 1};
  EXPECT_EQ(to_ros_yaml(map, "hall.pgm"),
            "image: hall.pgm\nresolution: 0.05\norigin: [1.230, -2.500, 0.0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
  for (const std::string_view name : {"a b.pgm", "#1: new.pgm", "'", "\"a\\\"", "- x", "äö.pgm"}) {
    const RosMapInfo info = read(to_ros_yaml(map, name));
    EXPECT_EQ(info.image, name);
    EXPECT_DOUBLE_EQ(info.origin_x, 1.23);
    EXPECT_DOUBLE_EQ(info.origin_y, -2.5);
  }
}

}  // namespace ros_yaml_test

}  // namespace rack::localisation
