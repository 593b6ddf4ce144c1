#include "components/geometry/dxf_layers.h"

#include <gtest/gtest.h>

namespace rack {

namespace dxf_layers_test {

using Texts = std::vector<std::string>;

Texts report_of(const DxfLayers& layers) {
  DxfRemarks remarks;
  layers.report(remarks);
  return remarks.texts();
}

TEST(DxfLayers, PatternsHaveStarsAndQuestionMarks) {
  EXPECT_TRUE(matches_pattern("walls", "walls"));
  EXPECT_TRUE(matches_pattern("walls", "w*"));
  EXPECT_TRUE(matches_pattern("walls", "*"));
  EXPECT_TRUE(matches_pattern("", "*"));
  EXPECT_TRUE(matches_pattern("", ""));
  EXPECT_TRUE(matches_pattern("a-wall-ext", "a-*-e?t*"));
  EXPECT_TRUE(matches_pattern("aaab", "*a?b"));
  EXPECT_FALSE(matches_pattern("walls", "wall"));
  EXPECT_FALSE(matches_pattern("wall", "walls"));
  EXPECT_FALSE(matches_pattern("wall", "?"));
  EXPECT_FALSE(matches_pattern("", "?"));
  EXPECT_FALSE(matches_pattern(std::string(60, 'a'), "*a*a*a*a*a*a*a*a*b")) << "in no time";
}

TEST(DxfLayers, AreChosenByName) {
  const auto takes = [](const char* choice, const char* name) {
    DxfLayers layers(choice);
    return layers.takes(layers.index(name));
  };
  EXPECT_TRUE(takes("", "exits"));
  EXPECT_TRUE(takes(" , ", "exits"));
  EXPECT_TRUE(takes("Walls, pillars", "WALLS"));
  EXPECT_TRUE(takes("Walls, pillars", "pillars"));
  EXPECT_FALSE(takes("Walls, pillars", "exits"));
  EXPECT_FALSE(takes("-exits", "Exits"));
  EXPECT_TRUE(takes("-exits", "walls"));
  EXPECT_FALSE(takes("a*,-ab", "ab"));
  EXPECT_TRUE(takes("a*, - ab", "ac"));
  EXPECT_FALSE(takes("a*,-ab", "b"));
}

TEST(DxfLayers, ReportWhatIsLeftOut) {
  DxfLayers layers("walls,wals,-exits");
  layers.hide("off");
  EXPECT_FALSE(layers.shows(layers.index("OFF")));
  EXPECT_TRUE(layers.shows(layers.index("Exits")));
  EXPECT_FALSE(layers.takes(layers.index("exits")));
  EXPECT_FALSE(layers.takes(layers.index("EXITS")));
  EXPECT_TRUE(layers.takes(layers.index("walls")));
  const Texts expected = {"no layer is named \"wals\"; there are \"off\", \"Exits\", \"walls\"",
                          "layer \"off\" is off or frozen: 1 entities are left out",
                          "layer \"Exits\" is not chosen: 2 lines are left out"};
  EXPECT_EQ(report_of(layers), expected);
  EXPECT_EQ(report_of(DxfLayers("a")), Texts{"no layer is named \"a\"; there are none"});
}

TEST(DxfLayers, HaveTheNumberInTheirName) {
  DxfLayers layers;
  EXPECT_EQ(layers.number(layers.index("7")), 7);
  EXPECT_EQ(layers.number(layers.index("walls")), 0);
  EXPECT_NE(layers.index("7"), layers.index("walls"));
}

TEST(DxfLayers, AreBounded) {
  DxfLayers layers;
  for (std::size_t i = 0; i < DxfLayers::kLayersMax; ++i) layers.index("l" + std::to_string(i));
  const auto more = layers.index("one more");
  EXPECT_EQ(layers.index("another"), more);
  EXPECT_NE(layers.index("l5"), more);
  EXPECT_TRUE(layers.takes(more));
}

}  // namespace dxf_layers_test

}  // namespace rack
