#include "components/geometry/dxf.h"

#include <cmath>

#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack {

namespace dxf_test {

DxfDrawing read(const std::string& text) {
  auto drawing = read_dxf(text);
  EXPECT_TRUE(drawing.ok()) << drawing.error().detail();
  return drawing ? *std::move(drawing) : DxfDrawing{};
}

std::string refusal(const std::string& text) {
  const auto drawing = read_dxf(text);
  return drawing ? "it was read" : drawing.error().detail();
}

// "type 10=1 20=2": an entity, one group a word.
std::string entity(const std::string& words) {
  std::string text = "0\n";
  for (const char c : words) text += c == ' ' || c == '=' ? '\n' : c;
  return text + "\n";
}

std::string section(const std::string& name, const std::string& content) {
  return "0\nSECTION\n2\n" + name + "\n" + content + "0\nENDSEC\n";
}

const std::string kLine = entity("LINE 10=1 20=1 11=1 21=2");

using Remarks = std::vector<std::string>;

double off(const DxfPoint& a, double x, double y) { return std::hypot(a.x - x, a.y - y); }

TEST(Dxf, ReadsLines) {
  const auto drawing = read("0\nLINE\n8\n7\n10\n1.5\n20\n-2\n11\n+3e1\n21\n 4 \r\n0\nEOF\n");
  ASSERT_EQ(drawing.lines.size(), 1U);
  EXPECT_EQ(drawing.lines[0].from.x, 1.5);
  EXPECT_EQ(drawing.lines[0].from.y, -2);
  EXPECT_EQ(drawing.lines[0].to.x, 30);
  EXPECT_EQ(drawing.lines[0].to.y, 4);
  EXPECT_EQ(drawing.lines[0].layer, 7);
  EXPECT_EQ(read(kLine).lines.size(), 1U) << "without an end of the file";
}

TEST(Dxf, OfTheSectionEntitiesOnly) {
  const auto drawing = read(section("BLOCKS", kLine) + section("OBJECTS", kLine) +
                            section("ENTITIES", kLine + entity("HATCH 10=1")) +
                            section("CLASSES", kLine) + "0\nEOF\n");
  EXPECT_EQ(drawing.lines.size(), 1U);
  EXPECT_EQ(drawing.others, 1U);
  EXPECT_EQ(drawing.remarks, Remarks{"left out, since they are not lines of walls: 1 HATCH"});
}

const std::string kVertices = entity("VERTEX 10=0 20=0") + entity("VERTEX 10=5 20=0") +
                              entity("VERTEX 10=5 20=5") + entity("SEQEND");

TEST(Dxf, ReadsPolylinesAndPoints) {
  EXPECT_EQ(read(entity("POLYLINE 10=9 20=9") + kVertices).lines.size(), 2U);
  EXPECT_EQ(read(entity("POLYLINE 70=1") + kVertices).lines.size(), 3U) << "closed";
  EXPECT_EQ(read(entity("POLYLINE 70=64") + kVertices).lines.size(), 0U) << "a mesh";
  EXPECT_EQ(read(entity("POLYLINE 70=9") + kVertices).lines.size(), 3U) << "in space";
  const auto light = read(entity("LWPOLYLINE 90=2 10=1 20=2 10=3 20=4"));
  ASSERT_EQ(light.lines.size(), 1U);
  EXPECT_EQ(light.lines[0].from.y, 2);
  EXPECT_EQ(light.lines[0].to.x, 3);
  EXPECT_EQ(read(entity("LWPOLYLINE 90=2 70=1 10=1 20=2 10=3 20=4")).lines.size(), 1U);
  EXPECT_EQ(read(entity("POINT 10=1 20=2")).lines.size(), 1U);
}

TEST(Dxf, APolylineIsOnItsOwnLayerAndSide) {
  const auto drawing = read(entity("POLYLINE 8=4 230=-1") + entity("VERTEX 8=9 10=1 20=0") +
                            entity("VERTEX 8=9 10=5 20=0 70=16") + entity("VERTEX 8=9 10=3 20=0") +
                            entity("SEQEND 8=9"));
  ASSERT_EQ(drawing.lines.size(), 1U) << "without the frame of a spline";
  EXPECT_EQ(drawing.lines[0].layer, 4);
  EXPECT_EQ(drawing.lines[0].from.x, -1);
  EXPECT_EQ(drawing.lines[0].to.x, -3);
}

TEST(Dxf, BulgesAreArcs) {
  const auto light = read(entity("LWPOLYLINE 90=2 70=1 10=0 20=0 42=1 10=2 20=0 42=1"));
  ASSERT_EQ(light.lines.size(), 72U) << "a circle of two halves";
  for (const DxfLine& line : light.lines) EXPECT_NEAR(off(line.from, 1, 0), 1, 1e-9);
  const auto old = read(entity("POLYLINE 70=0") + entity("VERTEX 10=0 20=0 42=-1") +
                        entity("VERTEX 10=2 20=0") + entity("SEQEND"));
  ASSERT_EQ(old.lines.size(), 36U);
  EXPECT_LT(off(old.lines[17].to, 1, 1), 1e-9) << "on the left";
  // A bulge before the first vertex: dxflib writes before its memory.
  EXPECT_EQ(read(entity("LWPOLYLINE 90=2 42=1 20=7 10=0 20=0 10=2")).lines.size(), 1U);
}

TEST(Dxf, CurvesAreChords) {
  const auto circle = read(entity("CIRCLE 8=3 10=1 20=2 40=0.5"));
  ASSERT_EQ(circle.lines.size(), 72U);
  EXPECT_LT(off(circle.lines[0].from, 1.5, 2), 1e-9);
  EXPECT_LT(off(circle.lines[71].to, 1.5, 2), 1e-9);
  EXPECT_EQ(circle.lines[5].layer, 3);
  const auto arc = read(entity("ARC 10=0 20=0 40=2 50=350 51=80"));
  ASSERT_EQ(arc.lines.size(), 18U);
  EXPECT_LT(off(arc.lines[2].from, 2, 0), 1e-9);
  const auto ellipse =
      read(entity("ELLIPSE 10=1 20=0 11=0 21=4 40=0.25 41=0 42=1.5707963267948966"));
  ASSERT_EQ(ellipse.lines.size(), 18U);
  EXPECT_LT(off(ellipse.lines[0].from, 1, 4), 1e-9);
  EXPECT_LT(off(ellipse.lines[17].to, 0, 0), 1e-9);
  EXPECT_EQ(read(entity("ELLIPSE 10=1 20=0 11=0 21=4 40=0.25")).lines.size(), 72U);
  EXPECT_EQ(read(entity("CIRCLE 10=0 20=0 40=0")).remarks,
            Remarks{"line 1: CIRCLE has no radius of more than 0"});
}

// What is drawn on the back of the plane has its x the other way round (AutoCAD's arbitrary axis).
TEST(Dxf, WhatIsMirroredIsOnTheOtherSide) {
  const auto circle = read(entity("CIRCLE 10=5 20=2 40=1 210=0 220=0 230=-1"));
  ASSERT_EQ(circle.lines.size(), 72U);
  EXPECT_LT(off(circle.lines[0].from, -6, 2), 1e-9);
  const auto arc = read(entity("ARC 10=0 20=0 40=2 50=0 51=90 230=-1"));
  EXPECT_LT(off(arc.lines[0].from, -2, 0), 1e-9);
  EXPECT_LT(off(arc.lines.back().to, 0, 2), 1e-9);
  const auto light = read(entity("LWPOLYLINE 90=2 230=-1 10=1 20=2 42=1 10=3 20=2"));
  EXPECT_LT(off(light.lines[17].to, -2, 1), 1e-9);
  const auto ellipse =
      read(entity("ELLIPSE 10=0 20=0 11=4 21=0 40=0.5 41=0 42=1.5707963267948966 230=-1"));
  EXPECT_LT(off(ellipse.lines.front().from, 4, 0), 1e-9) << "its coordinates are the drawing's";
  EXPECT_LT(off(ellipse.lines.back().to, 0, -2), 1e-9);
  const auto line = read(entity("LINE 10=1 20=1 11=1 21=2 230=-1"));
  EXPECT_EQ(line.lines[0].from.x, 1) << "so are those of a line";
}

TEST(Dxf, TiltedPlanesAreReported) {
  const char* const tilted = "is drawn in a tilted plane: flatten the drawing";
  const auto drawing = read(entity("CIRCLE 10=0 20=0 40=1 210=1 220=0 230=0") +
                            entity("LWPOLYLINE 90=2 220=0.1 10=1 20=2 10=3 20=2") +
                            entity("INSERT 2=a 10=0 20=0 210=0 220=0 230=0"));
  EXPECT_TRUE(drawing.lines.empty());
  const Remarks expected = {std::string("line 1: CIRCLE ") + tilted,
                            std::string("line 15: LWPOLYLINE ") + tilted,
                            std::string("line 29: INSERT ") + tilted};
  EXPECT_EQ(drawing.remarks, expected);
}

std::string block(const std::string& name, const std::string& content,
                  const std::string& groups = "10=0 20=0") {
  return entity("BLOCK 2=" + name + " " + groups) + content + entity("ENDBLK");
}

TEST(Dxf, InsertsBlocks) {
  const std::string chair =
      block("chair", entity("LINE 8=0 10=1 20=1 11=2 21=1") + entity("CIRCLE 8=5 10=1 20=1 40=1"),
            "10=1 20=1");
  const auto drawing =
      read(section("BLOCKS", chair) +
           section("ENTITIES", entity("INSERT 8=2 2=Chair 10=10 20=20 41=2 42=2 50=90")));
  EXPECT_TRUE(drawing.remarks.empty());
  ASSERT_EQ(drawing.lines.size(), 73U);
  EXPECT_LT(off(drawing.lines[0].from, 10, 20), 1e-9);
  EXPECT_LT(off(drawing.lines[0].to, 10, 22), 1e-9) << "twice as long, and rotated";
  EXPECT_EQ(drawing.lines[0].layer, 2);
  EXPECT_EQ(drawing.lines[1].layer, 5);
  EXPECT_LT(off(drawing.lines[1].from, 10, 22), 1e-9);
}

TEST(Dxf, InsertsRowsAlsoOnTheBack) {
  const std::string dot = block("dot", entity("POINT 10=0 20=0"));
  const auto drawing = read(
      section("BLOCKS", dot) +
      section("ENTITIES", entity("INSERT 2=dot 10=1 20=2 50=90 70=2 71=2 44=10 45=100 230=-1")));
  ASSERT_EQ(drawing.lines.size(), 4U);
  EXPECT_LT(off(drawing.lines[0].from, -1, 2), 1e-9);
  EXPECT_LT(off(drawing.lines[1].from, -1, 12), 1e-9) << "the next column, along the rotated x";
  EXPECT_LT(off(drawing.lines[2].from, 99, 2), 1e-9) << "the next row";
}

TEST(Dxf, BlocksAreInBlocks) {
  const auto drawing =
      read(section("BLOCKS", block("outer", entity("INSERT 2=inner 10=5 20=0 8=0")) +
                                 block("inner", entity("POINT 10=1 20=1 8=0")) +
                                 block("loop", entity("INSERT 2=loop 10=1 20=1")) +
                                 block("other", "", "70=4 1=file.dxf")) +
           section("ENTITIES", entity("INSERT 2=outer 10=100 20=0 8=6") +
                                   entity("INSERT 2=loop 10=0 20=0") +
                                   entity("INSERT 2=other 10=0 20=0") + entity("ATTRIB 10=1 20=1") +
                                   entity("SEQEND") + entity("INSERT 2=none 10=0 20=0")));
  ASSERT_EQ(drawing.lines.size(), 1U);
  EXPECT_LT(off(drawing.lines[0].from, 106, 1), 1e-9);
  EXPECT_EQ(drawing.lines[0].layer, 6);
  ASSERT_EQ(drawing.remarks.size(), 4U);
  EXPECT_NE(drawing.remarks[0].find("1 ATTRIB"), std::string::npos);
  EXPECT_NE(drawing.remarks[1].find("INSERT of block \"loop\" in itself"), std::string::npos);
  EXPECT_NE(drawing.remarks[2].find("\"other\" which is in another file"), std::string::npos);
  EXPECT_NE(drawing.remarks[3].find("\"none\" which the drawing does not"), std::string::npos);
}

// A block whose BLOCK cannot be read does not continue the one before it.
TEST(Dxf, ABlockEndsWithTheNextOrTheSection) {
  const std::string point = entity("POINT 10=1 20=1");
  const auto drawing =
      read(section("BLOCKS", entity("BLOCK 2=a") + point + entity("BLOCK 2= 10=1") + point +
                                 entity("BLOCK 2=b") + point + point) +
           section("ENTITIES", entity("INSERT 2=a 10=0 20=0") + point));
  EXPECT_EQ(drawing.lines.size(), 2U);
  EXPECT_EQ(drawing.remarks.size(), 1U);
}

TEST(Dxf, PaperSpaceAndWhatIsInvisibleAreLeftOut) {
  const auto drawing =
      read(entity("LINE 67=1 10=1 20=1 11=1 21=2") + entity("LINE 67=0 10=1 20=1 11=1 21=2") +
           entity("LINE 60=1 10=1 20=1 11=1 21=2") + entity("POLYLINE 67=1") + kVertices +
           entity("POLYLINE 60=1") + kVertices + entity("INSERT 67=1 2=none 10=0 20=0"));
  EXPECT_EQ(drawing.lines.size(), 1U);
  EXPECT_EQ(drawing.others, 5U);
  const Remarks expected = {"3 entities in the paper space are left out",
                            "2 invisible entities are left out"};
  EXPECT_EQ(drawing.remarks, expected);
}

TEST(Dxf, LayersThatAreOffOrFrozenAreLeftOut) {
  const std::string tables = section(
      "TABLES", entity("TABLE 2=LAYER 70=4") + entity("LAYER 2=1 70=0 62=7") +
                    entity("LAYER 2=Furniture 70=1 62=7") + entity("LAYER 2=off 70=0 62=-7") +
                    entity("LAYER 2=locked 70=4 62=1") + entity("ENDTAB"));
  const auto on = [](const std::string& layer) {
    return entity("LINE 8=" + layer + " 10=1 20=1 11=1 21=2");
  };
  const auto drawing =
      read(tables + section("BLOCKS", block("a", on("0") + on("FURNITURE"))) +
           section("ENTITIES", on("1") + on("FURNITURE") + on("off") + on("locked") + on("none") +
                                   entity("INSERT 8=1 2=a 10=0 20=0") +
                                   entity("INSERT 8=off 2=a 10=0 20=0")));
  EXPECT_EQ(drawing.lines.size(), 4U);
  const Remarks expected = {"layer \"Furniture\" is off or frozen: 2 entities are left out",
                            "layer \"off\" is off or frozen: 2 entities are left out"};
  EXPECT_EQ(drawing.remarks, expected);
}

// What is on layer 0 of a block has the layer of the INSERT.
TEST(Dxf, LayersAreChosen) {
  const auto on = [](const std::string& layer) {
    return entity("LINE 8=" + layer + " 10=1 20=1 11=1 21=2");
  };
  const std::string text =
      section("BLOCKS", block("a", on("0") + on("Walls"))) +
      section("ENTITIES", on("walls") + on("EXITS") + entity("CIRCLE 8=exits 10=0 20=0 40=1") +
                              entity("INSERT 8=exits 2=a 10=0 20=0"));
  const auto chosen = [&](std::string_view layers) {
    const auto drawing = read_dxf(text, layers);
    EXPECT_TRUE(drawing.ok());
    return std::pair(drawing->lines.size(), drawing->remarks);
  };
  EXPECT_EQ(chosen(""), std::pair(std::size_t{76}, Remarks{}));
  const Remarks without_exits = {"layer \"EXITS\" is not chosen: 74 lines are left out"};
  EXPECT_EQ(chosen("walls"), std::pair(std::size_t{2}, without_exits));
  EXPECT_EQ(chosen("-Exits"), std::pair(std::size_t{2}, without_exits));
  EXPECT_EQ(chosen("e*").first, 74U);
  const auto none = read_plan("a.dxf", text, {.layers = "wals"});
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().detail().find("a.dxf: no lines: no layer is named \"wals\"; there are "),
            0U)
      << none.error().detail();
}

TEST(Dxf, ADrawingOfWhichAllIsLeftOutSaysWhy) {
  const auto plan = read_plan("a.dxf", entity("SPLINE"), {});
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().detail(),
            "a.dxf: no lines: line 1: SPLINE is not read (1 of them): use polylines");
  EXPECT_TRUE(read_plan("a.dxf", "0\nEOF\n", {})) << "nothing is left out of an empty one";
}

TEST(Dxf, StatesItsUnit) {
  const auto with_unit = [](const std::string& unit) {
    return read(section("HEADER", "9\n$ACADVER\n1\nAC1015\n9\n$INSUNITS\n70\n" + unit +
                                      "\n9\n$EXTMIN\n10\n0\n20\n0\n") +
                section("ENTITIES", kLine));
  };
  EXPECT_EQ(with_unit("4").unit, 1);
  EXPECT_EQ(with_unit("6").unit, 1000);
  EXPECT_EQ(with_unit("1").unit, 25.4);
  EXPECT_EQ(with_unit("0").unit, 0);
  EXPECT_TRUE(with_unit("0").remarks.empty());
  EXPECT_EQ(with_unit("18").unit, 0);
  EXPECT_EQ(with_unit("18").remarks,
            Remarks{"line 9: $INSUNITS 18 is not known as a unit of floor plans"});
  EXPECT_EQ(with_unit("6").lines.size(), 1U);
  EXPECT_EQ(read(kLine).unit, 0);
}

TEST(Dxf, ReportsTypesThatMayBeWalls) {
  const auto drawing = read(entity("SPLINE 72=2000000000 40=1") + entity("TEXT 10=1 20=1") + kLine +
                            entity("SPLINE") + entity("SOLID") + entity("DIMENSION 70=0"));
  EXPECT_EQ(drawing.lines.size(), 1U);
  EXPECT_EQ(drawing.others, 5U);
  const Remarks expected = {"left out, since they are not lines of walls: 1 DIMENSION, 1 TEXT",
                            "line 1: SPLINE is not read (2 of them): use polylines",
                            "line 25: SOLID is not read (1 of them): use polylines"};
  EXPECT_EQ(drawing.remarks, expected);
}

TEST(Dxf, SkipsDamagedPartsAndReportsThem) {
  const auto drawing = read(
      "0\nLINE\n10\n1\n20\n1\n0\nLINE\n10\nnan\n20\n1\n11\n1\n21\n1\n"
      "0\nLWPOLYLINE\n90\n2000000000\n10\n1\n20\n1\n0\nVERTEX\n10\n1\n20\n1\n"
      "0\nPOINT\n10\n1e300\n20\n1\n0\nPOLYLINE\n10\n1\n20\n1\n0\nVERTEX\n10\n1\n20\n1\n");
  EXPECT_TRUE(drawing.lines.empty());
  const Remarks expected = {
      "line 1: LINE without an end",
      "line 7: LINE a coordinate is not a number",
      "line 17: LWPOLYLINE has a wrong number of vertices",
      "line 25: VERTEX without POLYLINE",
      "line 31: POINT a coordinate is not a number",
      "line 37: POLYLINE without SEQEND",
  };
  EXPECT_EQ(drawing.remarks, expected);
  const auto spoiled =
      read(entity("POLYLINE 70=0") + entity("VERTEX 10=1 20=1") + entity("VERTEX 10=x 20=1") +
           entity("VERTEX 10=2 20=1") + entity("SEQEND") + kLine);
  EXPECT_EQ(spoiled.lines.size(), 1U);
  EXPECT_EQ(spoiled.remarks, Remarks{"line 1: POLYLINE a coordinate is not a number"});
}

TEST(Dxf, RefusesWhatIsNoDxf) {
  EXPECT_EQ(refusal("hello\nworld\n"), "line 1: no group code");
  EXPECT_EQ(refusal("0\nLINE\n10"), "line 3: a group code without value");
  EXPECT_EQ(refusal("AutoCAD Binary DXF\r\n"), "binary DXF: save it as text");
  EXPECT_EQ(refusal("AC1032\0\0"), "a DWG drawing: save it as DXF");
  EXPECT_EQ(refusal("\xFF\xFE"
                    "0"),
            "UTF-16: save it as DXF in UTF-8 or ASCII");
  EXPECT_EQ(read("\xEF\xBB\xBF" + kLine).lines.size(), 1U) << "with a byte order mark";
  EXPECT_TRUE(read("").lines.empty());
  EXPECT_TRUE(read("0\nEOF\nwhatever").lines.empty());
}

TEST(Dxf, LinesAreBounded) {
  std::string most;
  for (std::size_t i = 0; i < DxfDrawing::kLinesMax; ++i) most += "0\nPOINT\n10\n1\n20\n1\n";
  EXPECT_EQ(read(most).lines.size(), DxfDrawing::kLinesMax);
  EXPECT_TRUE(read(most).remarks.empty());
  const auto more = read(most + kLine);
  EXPECT_EQ(more.lines.size(), DxfDrawing::kLinesMax);
  EXPECT_EQ(more.remarks, Remarks{"the drawing has more than 20000 lines: the rest is left out"});
}

TEST(Dxf, RemarksAreBounded) {
  std::string faults;
  for (std::size_t i = 0; i < DxfDrawing::kRemarksMax + 100; ++i) faults += "0\nPOINT\n10\n1\n";
  const auto drawing = read(entity("TEXT") + faults);
  ASSERT_EQ(drawing.remarks.size(), DxfDrawing::kRemarksMax);
  EXPECT_EQ(drawing.remarks.front(), "left out, since they are not lines of walls: 1 TEXT");
  EXPECT_EQ(drawing.remarks.back(), "and 102 more");
}

// Lines longer than dxflib's buffer, zeros, and empty values.
TEST(Dxf, StrangeTextsDoNoHarm) {
  const std::string long_text(5000, 'x');
  EXPECT_EQ(read(entity("LINE 8=" + long_text) + kLine).lines.size(), 1U);
  EXPECT_EQ(read("999\n" + long_text + "\n999\ndxflib\n" + entity("TEXT 1=" + long_text) + kLine)
                .lines.size(),
            1U);
  using std::string_literals::operator""s;
  EXPECT_EQ(
      read("0\nLINE\0\n8\n\n"s + "0\nLINE\n8\n\0\n10\n1\n20\n1\n11\n1\n21\n2\n"s).lines.size(), 1U);
  EXPECT_EQ(read("0\n\n-5\n\n0\n0\n-0\n1\n").lines.size(), 0U);
}

}  // namespace dxf_test

}  // namespace rack
