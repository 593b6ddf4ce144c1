#include "components/localisation/line_map.h"

#include <limits>

#include <gtest/gtest.h>

namespace rack::localisation {

namespace line_map_test {

FeatureMapDataPoint line(double x, double y, double x2, double y2, i32 layer = 0) {
  return {.x = x, .y = y, .x2 = x2, .y2 = y2, .layer = layer};
}

TEST(LineMap, CountsLinesThatAreTooFarAway) {
  DxfPlan plan;
  plan.drawing.lines = {{{0, 0}, {1, 1}}, {{0, 0}, {1e7, 1}}};
  const LineMap map(plan);
  EXPECT_EQ(map.size(), 1U);
  EXPECT_EQ(map.left_out(), 1U);
}

TEST(LineMap, ThroughDxfAndBack) {
  LineMap map;
  ASSERT_TRUE(map.add(line(1000, -2000, 3000, 4000.5, 2)).ok());
  ASSERT_TRUE(map.add(line(0, 0, 0, 1)).ok());
  const PlanPlacement scale{.scale = 10, .offset_x = 5, .offset_y = -7};
  const auto drawing = read_dxf(map.to_dxf(scale));
  ASSERT_TRUE(drawing.ok()) << drawing.error().detail();
  EXPECT_TRUE(drawing->remarks.empty());
  LineMap back({*drawing, scale});
  EXPECT_EQ(back.left_out(), 0U);
  FeatureMapData data;
  back.fill({}, data);
  ASSERT_EQ(data.features.size(), 2U);
  EXPECT_NEAR(data.features[0].x, 1000, 0.01);
  EXPECT_NEAR(data.features[0].y, -2000, 0.01);
  EXPECT_NEAR(data.features[0].y2, 4000.5, 0.01);
  EXPECT_EQ(data.features[0].layer, 2);
}

TEST(LineMap, LengthAndDirectionFollowFromTheEnds) {
  LineMap map;
  ASSERT_TRUE(map.add({.x = 0, .y = 0, .x2 = 0, .y2 = 500, .l = 7, .rho = 7, .type = 0}).ok());
  FeatureMapData data;
  map.fill({}, data);
  EXPECT_NEAR(data.features[0].l, 500, 1e-9);
  EXPECT_NEAR(data.features[0].rho, kPi / 2, 1e-9);
  EXPECT_NEAR(data.features[0].sin, 1, 1e-9);
  EXPECT_EQ(data.features[0].type, FeatureMapDataPoint::kLine);
}

TEST(LineMap, EditsByThePlaceInTheNewestDataSet) {
  LineMap map;
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(map.add(line(i, 0, i, 9, i)).ok());
  EXPECT_FALSE(map.erase(0).ok()) << "no data set was made";
  FeatureMapLayerData layers;
  layers.layers = {1, 3, 99, -1};
  map.show(layers);
  EXPECT_EQ(map.layers().layers.size(), 2U);
  FeatureMapData data;
  map.fill({}, data);
  ASSERT_EQ(data.features.size(), 2U);
  ASSERT_TRUE(map.displace(1, line(70, 0, 70, 9)).ok());
  ASSERT_TRUE(map.erase(0).ok());
  EXPECT_FALSE(map.erase(0).ok()) << "it is gone";
  EXPECT_FALSE(map.displace(0, line(1, 1, 1, 1)).ok());
  ASSERT_TRUE(map.displace(1, line(80, 0, 80, 9)).ok()) << "places stay until the next data set";
  EXPECT_FALSE(map.erase(2).ok());
  EXPECT_FALSE(map.erase(-1).ok());
  EXPECT_EQ(map.size(), 3U);
  map.fill({}, data);
  ASSERT_EQ(data.features.size(), 1U);
  EXPECT_EQ(data.features[0].x, 80);
  EXPECT_EQ(data.features[0].layer, 3) << "a line stays in its layer";
}

TEST(LineMap, TheNearestOfTooMany) {
  LineMap map;
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(map.add(line(100 * i, -10, 100 * i, 10)).ok());
  FeatureMapData data;
  map.fill({.x = 25000}, data);
  ASSERT_EQ(data.features.size(), 200U);
  for (const auto& feature : data.features) EXPECT_NEAR(feature.x, 25000, 10001);
  ASSERT_TRUE(map.erase(0).ok());
  EXPECT_EQ(map.size(), 499U);
}

TEST(LineMap, RefusesWhatIsNoLine) {
  LineMap map;
  EXPECT_FALSE(map.add(line(std::numeric_limits<double>::quiet_NaN(), 0, 0, 0)).ok());
  EXPECT_FALSE(map.add(line(0, std::numeric_limits<double>::infinity(), 0, 0)).ok());
  EXPECT_FALSE(map.add(line(0, 0, 1, 1, 20)).ok());
  EXPECT_FALSE(map.add(line(0, 0, 1, 1, -1)).ok());
  for (std::size_t i = 0; i < LineMap::kLinesMax; ++i) ASSERT_TRUE(map.add(line(0, 0, 1, 1)).ok());
  EXPECT_FALSE(map.add(line(0, 0, 1, 1)).ok());
}

}  // namespace line_map_test

}  // namespace rack::localisation
