#include "components/geometry/dxf_entity.h"

#include <gtest/gtest.h>

namespace rack {

namespace dxf_entity_test {

std::vector<DxfEntity> all_of(std::string_view text) {
  std::vector<DxfEntity> all;
  DxfEntities entities(text);
  for (;;) {
    auto entity = entities.next();
    EXPECT_TRUE(entity.ok()) << entity.error().detail();
    if (!entity || !*entity) return all;
    all.push_back(**entity);
  }
}

std::string error_of(std::string_view text) {
  DxfEntities entities(text);
  for (;;) {
    const auto entity = entities.next();
    if (!entity) return entity.error().detail();
    if (!*entity) return "it was read";
  }
}

std::string fault_of(const std::string& text) {
  const std::string whole = "0\n" + text;
  const auto entities = all_of(whole);
  return entities.empty() ? "none" : entities.front().fault();
}

TEST(DxfEntity, IsPutTogetherFromGroups) {
  const std::string text =
      " 999 \r\na comment\r\n  0\r\nLINE\r\n  8\r\n walls \r\n 10\r\n1\r\n 10\r\n2\r\n1000\r\nx\r\n"
      "9\n$INSUNITS\n70\n6\n0\nPOINT\n0\nEOF\nwhatever";
  const auto entities = all_of(text);
  ASSERT_EQ(entities.size(), 3U);
  EXPECT_EQ(entities[0].type, "LINE");
  EXPECT_EQ(entities[0].line, 3U);
  EXPECT_EQ(entities[0].groups.size(), 3U) << "without comments and extended data";
  EXPECT_EQ(entities[0].value(8), "walls");
  EXPECT_EQ(entities[0].value(10), "2") << "the last one";
  EXPECT_EQ(entities[0].count(10), 2U);
  EXPECT_EQ(entities[1].type, "$INSUNITS");
  EXPECT_EQ(entities[1].number(70, 0), 6);
  EXPECT_EQ(entities[1].number(71, -5), -5);
  EXPECT_EQ(entities[2].type, "POINT");
  EXPECT_EQ(entities[2].line, 17U);
  EXPECT_TRUE(all_of("").empty());
  EXPECT_TRUE(all_of("0\nEOF\n").empty());
  EXPECT_TRUE(all_of("10\n1\n").empty()) << "of no entity";
}

TEST(DxfEntity, WhatIsNoDxfIsRefusedWithItsLine) {
  EXPECT_EQ(error_of("hello\nworld\n"), "line 1: no group code");
  EXPECT_EQ(error_of("0\nLINE\n10"), "line 3: a group code without value");
  EXPECT_EQ(error_of("0\nLINE\n10\n1\n1.5\n2\n"), "line 5: no group code");
  EXPECT_EQ(error_of("99999999999\n2\n"), "line 1: no group code");
}

TEST(DxfEntity, MustBeComplete) {
  EXPECT_EQ(fault_of("LINE\n10\n1\n20\n1\n11\n2\n21\n2\n"), "");
  EXPECT_EQ(fault_of("LINE\n10\n1\n20\n1\n11\n2\n"), "without an end");
  EXPECT_EQ(fault_of("POINT\n10\n1\n"), "without coordinates");
  EXPECT_EQ(fault_of("ARC\n10\n1\n20\n1\n40\n1\n50\n0\n"), "without centre, radius or angles");
  EXPECT_EQ(fault_of("INSERT\n2\n\n10\n1\n20\n1\n"), "without the name of a block or coordinates");
  EXPECT_EQ(fault_of("BLOCK\n70\n0\n"), "without a name");
  EXPECT_EQ(fault_of("POLYLINE\n70\n64\n"), "is a mesh");
  EXPECT_EQ(fault_of("SPLINE\n"), "") << "not read";
}

// dxflib would take them for 0, or stop at the first wrong character.
TEST(DxfEntity, NumbersMustBeNumbers) {
  for (const char* number : {"1", "-1.5", "+3e1", " 4 ", "1e9", ".5", "1E-3"})
    EXPECT_EQ(fault_of(std::string("CIRCLE\n20\n0\n40\n1\n10\n") + number + "\n"), "") << number;
  for (const char* number :
       {"nan", "inf", "1e300", "1.1e9", "-1e10", "1,5", "1.5x", "0x10", "", "--1"})
    EXPECT_EQ(fault_of(std::string("CIRCLE\n20\n0\n40\n1\n10\n") + number + "\n"),
              "a coordinate is not a number")
        << number;
  EXPECT_EQ(fault_of("CIRCLE\n10\n1\n20\n1\n40\n1\n230\nup\n"), "a coordinate is not a number");
}

// As many vertices as are announced, else dxflib writes out of bounds or allocates what is not
// there.
TEST(DxfEntity, TheVerticesOfAPolylineMustBeThere) {
  EXPECT_EQ(fault_of("LWPOLYLINE\n90\n1\n10\n1\n20\n1\n"), "");
  EXPECT_EQ(fault_of("LWPOLYLINE\n10\n1\n20\n1\n"), "") << "not announced";
  for (const char* count : {"2", "0", "-1", "2000000000", "99999999999", "x"})
    EXPECT_EQ(fault_of(std::string("LWPOLYLINE\n90\n") + count + "\n10\n1\n20\n1\n"),
              "has a wrong number of vertices")
        << count;
  EXPECT_EQ(fault_of("LWPOLYLINE\n10\n1\n"), "has a vertex without coordinates");
  EXPECT_EQ(fault_of("LWPOLYLINE\n90\n0\n"), "without vertices");
  std::string most = "LWPOLYLINE\n";
  for (std::size_t i = 0; i < DxfEntity::kVerticesMax; ++i) most += "10\n1\n20\n1\n";
  EXPECT_EQ(fault_of(most), "");
  EXPECT_EQ(fault_of(most + "10\n1\n20\n1\n"), "has more than 20000 vertices");
}

TEST(DxfEntity, HasLimits) {
  const auto named = [](std::size_t size) {
    return fault_of("BLOCK\n2\n" + std::string(size, 'x') + "\n");
  };
  EXPECT_EQ(named(DxfEntity::kValueMax), "");
  EXPECT_EQ(named(DxfEntity::kValueMax + 1), "has a value of more than 1000 characters");
  std::string most = "POINT\n10\n1\n20\n1\n";
  for (std::size_t i = 2; i < DxfEntity::kGroupsMax; ++i) most += "70\n1\n";
  EXPECT_EQ(fault_of(most), "");
  EXPECT_EQ(fault_of(most + "70\n1\n"), "is too long");
}

TEST(DxfEntity, IsGivenToTheLibraryInItsOrder) {
  EXPECT_EQ(all_of("0\nLINE\n8\na\n10\n1\n").front().text(), "0\nLINE\n8\na\n10\n1\n");
  EXPECT_EQ(all_of("9\n$INSUNITS\n70\n6\n").front().text(), "9\n$INSUNITS\n70\n6\n");
  EXPECT_EQ(all_of("0\nLWPOLYLINE\n42\n5\n20\n7\n10\n1\n20\n2\n42\n1\n90\n1\n").front().text(),
            "0\nLWPOLYLINE\n90\n1\n10\n1\n20\n2\n42\n1\n");
}

}  // namespace dxf_entity_test

}  // namespace rack
