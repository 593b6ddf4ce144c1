#include "components/geometry/dxf_units.h"

#include <gtest/gtest.h>

#include "components/geometry/dxf.h"

namespace rack {

namespace dxf_units_test {

TEST(DxfUnits, APlanWithoutOneMayHaveAnother) {
  const std::string text = "0\nLINE\n10\n0\n20\n0\n11\n1\n21\n1\n";
  EXPECT_FALSE(read_plan("a", text, {.scale = 0}));
  const auto plan = read_plan("a", text, {.scale = 0, .scale_otherwise = 10});
  ASSERT_TRUE(plan);
  EXPECT_EQ(plan->placement.scale, 10);
  ASSERT_EQ(plan->drawing.remarks.size(), 1U);
  EXPECT_EQ(plan->drawing.remarks[0],
            "a, it does not state its unit ($INSUNITS): read with 10 mm per unit");
  const std::string in_feet = "9\n$INSUNITS\n70\n2\n" + text;
  EXPECT_EQ(read_plan("a", "0\nSECTION\n2\nHEADER\n" + in_feet, {.scale = 0, .scale_otherwise = 10})
                ->placement.scale,
            304.8);
}

TEST(DxfUnits, HaveALength) {
  EXPECT_EQ(dxf_unit_length(1), 25.4);
  EXPECT_EQ(dxf_unit_length(4), 1);
  EXPECT_EQ(dxf_unit_length(5), 10);
  EXPECT_EQ(dxf_unit_length(6), 1000);
  EXPECT_NEAR(dxf_unit_length(21), 304.8006, 1e-4);
  for (const int code : {0, -1, 11, 18, 25, 1 << 30}) EXPECT_EQ(dxf_unit_length(code), 0) << code;
}

TEST(DxfUnits, AreFoundByTheirLength) {
  EXPECT_EQ(dxf_unit(1000), 6);
  EXPECT_EQ(dxf_unit(25.4), 1);
  EXPECT_EQ(dxf_unit(304.8), 2);
  for (const double mm : {0.0, -1.0, 50.0, 998.0, 1002.0}) EXPECT_EQ(dxf_unit(mm), 0) << mm;
}

TEST(DxfUnits, TheScaleIsThatWantedOrThatOfTheDrawing) {
  DxfDrawing inches;
  inches.unit = 25.4;
  EXPECT_EQ(*inches.scale(0), 25.4);
  EXPECT_TRUE(inches.remarks.empty());
  EXPECT_EQ(*inches.scale(25.41), 25.41);
  EXPECT_TRUE(inches.remarks.empty()) << "nearly the same";
  EXPECT_EQ(*inches.scale(1000), 1000);
  ASSERT_EQ(inches.remarks.size(), 1U);
  EXPECT_EQ(inches.remarks[0],
            "its unit is 25.4 mm by $INSUNITS, but it is read with 1000 mm per unit; with 0, its "
            "own unit is used");
  DxfDrawing unknown;
  EXPECT_EQ(*unknown.scale(1000), 1000);
  EXPECT_TRUE(unknown.remarks.empty());
  ASSERT_FALSE(unknown.scale(0).ok());
  EXPECT_NE(unknown.scale(0).error().detail().find("set the scale"), std::string::npos);
}

}  // namespace dxf_units_test

}  // namespace rack
