#include "components/geometry/floor_map.h"

#include <array>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack {

namespace floor_map_test {

DxfDrawing read(const std::string& text) {
  auto drawing = read_dxf(text);
  EXPECT_TRUE(drawing.ok()) << drawing.error().message();
  return drawing ? *std::move(drawing) : DxfDrawing{};
}

std::string refusal(const std::string& text) {
  const auto drawing = read_dxf(text);
  return drawing ? "it was read" : drawing.error().detail();
}

TEST(Dxf, ReadsLines) {
  const auto drawing = read("0\nLINE\n8\n7\n10\n1.5\n20\n-2\n11\n+3e1\n21\n 4 \r\n0\nEOF\n");
  ASSERT_EQ(drawing.lines.size(), 1U);
  EXPECT_EQ(drawing.lines[0].from.x, 1.5);
  EXPECT_EQ(drawing.lines[0].from.y, -2);
  EXPECT_EQ(drawing.lines[0].to.x, 30);
  EXPECT_EQ(drawing.lines[0].to.y, 4);
  EXPECT_EQ(drawing.lines[0].layer, 7);
}

TEST(Dxf, OfTheSectionEntitiesOnly) {
  const std::string line = "0\nLINE\n10\n1\n20\n1\n11\n1\n21\n2\n";
  const auto drawing =
      read("0\nSECTION\n2\nBLOCKS\n" + line + "0\nENDSEC\n0\nSECTION\n2\nENTITIES\n" + line +
           "0\nARC\n10\n1\n0\nENDSEC\n0\nEOF\n");
  EXPECT_EQ(drawing.lines.size(), 1U);
  EXPECT_EQ(drawing.others, 1U);
}

TEST(Dxf, ReadsPolylinesAndPoints) {
  const std::string vertices =
      "0\nVERTEX\n10\n0\n20\n0\n0\nVERTEX\n10\n5\n20\n0\n0\nVERTEX\n10\n5\n20\n5\n0\nSEQEND\n";
  EXPECT_EQ(read("0\nPOLYLINE\n10\n9\n20\n9\n" + vertices).lines.size(), 2U);
  EXPECT_EQ(read("0\nPOLYLINE\n70\n1\n" + vertices).lines.size(), 3U) << "closed";
  EXPECT_EQ(read("0\nPOLYLINE\n70\n64\n" + vertices).lines.size(), 0U) << "a mesh";
  const auto light = read("0\nLWPOLYLINE\n90\n2\n10\n1\n20\n2\n10\n3\n20\n4\n");
  ASSERT_EQ(light.lines.size(), 1U);
  EXPECT_EQ(light.lines[0].from.y, 2);
  EXPECT_EQ(light.lines[0].to.x, 3);
  EXPECT_EQ(read("0\nPOINT\n10\n1\n20\n2\n").lines.size(), 1U);
}

TEST(Dxf, SkipsDamagedPartsAndReportsThem) {
  const auto drawing = read(
      "0\nLINE\n10\n1\n20\n1\n0\nLINE\n10\nnan\n20\n1\n11\n1\n21\n1\n"
      "0\nLWPOLYLINE\n90\n2000000000\n10\n1\n20\n1\n0\nVERTEX\n10\n1\n20\n1\n"
      "0\nPOINT\n10\n1e300\n20\n1\n0\nPOLYLINE\n10\n1\n20\n1\n0\nVERTEX\n10\n1\n20\n1\n");
  EXPECT_TRUE(drawing.lines.empty());
  const std::vector<std::string> expected = {
      "line 1: LINE without an end",
      "line 7: LINE a coordinate is not a number",
      "line 17: LWPOLYLINE has a wrong number of vertices",
      "line 25: VERTEX without POLYLINE",
      "line 31: POINT a coordinate is not a number",
      "line 37: POLYLINE without SEQEND",
  };
  EXPECT_EQ(drawing.skipped, expected);
}

TEST(Dxf, RefusesWhatIsNoDxf) {
  EXPECT_EQ(refusal("hello\nworld\n"), "line 1: no group code");
  EXPECT_EQ(refusal("0\nLINE\n10"), "line 3: a group code without value");
  EXPECT_EQ(refusal("AutoCAD Binary DXF\r\n"), "binary DXF: save it as text");
  EXPECT_TRUE(read("").lines.empty());
  EXPECT_TRUE(read("0\nEOF\nwhatever").lines.empty());
}

TEST(Dxf, HasAnEnd) {
  std::string text;
  for (std::size_t i = 0; i < DxfDrawing::kLinesMax + 100; ++i) text += "0\nPOINT\n10\n1\n20\n1\n";
  const auto drawing = read(text);
  EXPECT_EQ(drawing.lines.size(), DxfDrawing::kLinesMax);
  EXPECT_EQ(drawing.skipped.size(), DxfDrawing::kSkippedMax);
}

}  // namespace floor_map_test

namespace floor_map_test {

// A room of 4 by 2 m, longer from north to south; drawn in metres.
FloorMap room() {
  DxfDrawing drawing;
  drawing.lines = {{{-1, -2}, {1, -2}}, {{1, -2}, {1, 2}}, {{1, 2}, {-1, 2}}, {{-1, 2}, {-1, -2}}};
  return {drawing, 1000, 0, 0};
}

double look(const FloorMap& map, double degrees, MapPoint from = {}) {
  std::array<double, 1> range{};
  map.cast({from, radians(degrees), 1}, 10000, range);
  return range[0];
}

TEST(FloorMap, LooksAroundInARoom) {
  const FloorMap map = room();
  EXPECT_EQ(map.size(), 4U);
  EXPECT_NEAR(look(map, 0), 2000, 1e-6);
  EXPECT_NEAR(look(map, 90), 1000, 1e-6);
  EXPECT_NEAR(look(map, 180), 2000, 1e-6);
  EXPECT_NEAR(look(map, -90), 1000, 1e-6);
  EXPECT_NEAR(look(map, 90, {0, 900}), 100, 1e-6);
  EXPECT_NEAR(look(map, degrees(std::atan2(1, 2))), std::hypot(1000, 2000), 1e-2) << "a corner";
}

TEST(FloorMap, OffsetsAreTakenOffTheDrawing) {
  DxfDrawing drawing;
  drawing.lines = {{{0, 5}, {10, 5}}};
  const FloorMap map(drawing, 100, 2, 3);
  EXPECT_NEAR(look(map, 0), 300, 1e-6);
  EXPECT_NEAR(map.clearance({0, -400}), std::hypot(300, 100), 1e-6);
}

TEST(FloorMap, NothingIsSeenBeyondTheRange) {
  EXPECT_EQ(look({}, 0), 10000);
  DxfDrawing drawing;
  drawing.lines = {{{-1, 11}, {1, 11}}, {{5, 5}, {5, 5}}};
  EXPECT_EQ(look({drawing, 1000, 0, 0}, 0), 10000);
}

TEST(FloorMap, SeenFromAWallItIsNear) {
  EXPECT_NEAR(look(room(), 90, {0, 1000}), 0, 1e-6);
  EXPECT_NEAR(look(room(), -90, {0, 1000}), 0, 1e-6);
}

TEST(FloorMap, AFanSeesWhatItsRaysSee) {
  std::minstd_rand random(1);
  std::uniform_real_distribution<double> place(-8, 8);
  DxfDrawing drawing;
  for (int i = 0; i < 300; ++i)
    drawing.lines.push_back({{place(random), place(random)}, {place(random), place(random)}});
  const FloorMap map(drawing, 1000, 0, 0);
  std::array<double, 361> ranges{};
  map.cast({{100, 200}, radians(-180 + 33), radians(1)}, 10000, ranges);
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const double degrees = -180 + 33 + static_cast<double>(i);
    EXPECT_NEAR(ranges[i], look(map, degrees, {100, 200}), 1e-6) << degrees;
  }
}

TEST(FloorMap, FromInsideNoRayGetsOut) {
  const FloorMap map = room();
  std::array<double, 3600> ranges{};
  map.cast({{-300, 123}, 0.001, radians(0.1)}, 10000, ranges);
  for (const double range : ranges) EXPECT_LT(range, 4500);
}

TEST(FloorMap, Clearance) {
  EXPECT_NEAR(room().clearance({0, 0}), 1000, 1e-6);
  EXPECT_NEAR(room().clearance({1900, 500}), 100, 1e-6);
  EXPECT_TRUE(std::isinf(FloorMap().clearance({0, 0})));
}

}  // namespace floor_map_test

}  // namespace rack
