#include "components/geometry/dxf_blocks.h"

#include <gtest/gtest.h>

#include "components/geometry/pose.h"

namespace rack {

namespace dxf_blocks_test {

DxfInsert insert_of(const std::string& block, const DxfPlace& place = {}) {
  return {.block = block, .line = 7, .place = place};
}

DxfStroke unit_stroke(std::int32_t layer = 0, bool is_of_layer_0 = true) {
  return {{{0, 0}, {1, 0}, layer}, is_of_layer_0};
}

struct Flat {
  std::vector<DxfLine> lines;
  std::vector<std::string> remarks;
};

Flat flatten(DxfBlocks& blocks, const DxfContent& model) {
  DxfRemarks remarks;
  DxfLayers layers;
  for (int i = 0; i < 10; ++i) layers.index(std::to_string(i));  // index and number are the same
  auto lines = blocks.flatten(model, layers, remarks);
  return {std::move(lines), remarks.texts()};
}

TEST(DxfPlace, IsAppliedFromTheInside) {
  const DxfPlace place =
      DxfPlace::moved({10, 0}) * DxfPlace::rotated(kPi / 2) * DxfPlace::scaled(2, 3);
  const DxfPoint point = place({1, 1});
  EXPECT_NEAR(point.x, 7, 1e-12);
  EXPECT_NEAR(point.y, 2, 1e-12);
  EXPECT_EQ((DxfPlace::mirrored() * DxfPlace::moved({1, 2}))({0, 0}).x, -1);
}

TEST(DxfBlocks, AreInsertedAtTheirPlace) {
  DxfBlocks blocks;
  DxfContent* const chair = blocks.add("Chair");
  chair->base = {1, 0};
  chair->strokes = {unit_stroke(), unit_stroke(5, false)};
  DxfContent model;
  model.inserts = {insert_of("CHAIR", DxfPlace::moved({10, 20}))};
  model.inserts[0].layer = 3;
  const Flat flat = flatten(blocks, model);
  EXPECT_TRUE(flat.remarks.empty());
  ASSERT_EQ(flat.lines.size(), 2U);
  EXPECT_EQ(flat.lines[0].from.x, 9);
  EXPECT_EQ(flat.lines[0].to.x, 10);
  EXPECT_EQ(flat.lines[0].to.y, 20);
  EXPECT_EQ(flat.lines[0].layer, 3) << "layer 0 is that of the INSERT";
  EXPECT_EQ(flat.lines[1].layer, 5);
}

TEST(DxfBlocks, RowsAndColumns) {
  DxfBlocks blocks;
  blocks.add("a")->strokes = {unit_stroke()};
  DxfContent model;
  model.inserts = {insert_of("a")};
  model.inserts[0].columns = 3;
  model.inserts[0].rows = 2;
  model.inserts[0].column_step = {10, 0};
  model.inserts[0].row_step = {0, 5};
  const Flat flat = flatten(blocks, model);
  ASSERT_EQ(flat.lines.size(), 6U);
  EXPECT_EQ(flat.lines[5].from.x, 20);
  EXPECT_EQ(flat.lines[5].from.y, 5);
}

TEST(DxfBlocks, ReportWhatIsNotInserted) {
  DxfBlocks blocks;
  blocks.add("self")->inserts = {insert_of("b")};
  blocks.add("b")->inserts = {insert_of("SELF")};
  blocks.add("b")->strokes = {};
  blocks.add("b")->inserts = {insert_of("SELF")};
  blocks.add("xref")->is_external = true;
  DxfContent model;
  model.inserts = {insert_of("no\033ne"), insert_of("self"), insert_of("xref")};
  const std::vector<std::string> expected = {
      "line 7: INSERT of block \"no?ne\" which the drawing does not contain",
      "line 7: INSERT of block \"SELF\" in itself",
      "line 7: INSERT of block \"xref\" which is in another file: bind it"};
  EXPECT_EQ(flatten(blocks, model).remarks, expected);
}

// b0 contains b1 contains b2 ...
DxfContent chain(DxfBlocks& blocks, int length, std::size_t times) {
  for (int i = 0; i < length; ++i) {
    DxfContent* const block = blocks.add("b" + std::to_string(i));
    if (i + 1 < length)
      block->inserts.assign(times, insert_of("b" + std::to_string(i + 1)));
    else
      block->strokes = {unit_stroke()};
  }
  DxfContent model;
  model.inserts = {insert_of("b0")};
  return model;
}

TEST(DxfBlocks, AreNestedUpTo16Deep) {
  DxfBlocks blocks;
  EXPECT_EQ(flatten(blocks, chain(blocks, DxfBlocks::kDepthMax, 1)).lines.size(), 1U);
  const Flat flat = flatten(blocks, chain(blocks, DxfBlocks::kDepthMax + 1, 1));
  EXPECT_TRUE(flat.lines.empty());
  ASSERT_EQ(flat.remarks.size(), 1U);
  EXPECT_EQ(flat.remarks[0], "line 7: INSERT of block \"b16\" within 16 other blocks");
}

TEST(DxfBlocks, LinesAreBounded) {
  DxfBlocks blocks;
  blocks.add("a")->strokes = {unit_stroke()};
  DxfContent model;
  model.inserts = {insert_of("a")};
  model.inserts[0].rows = DxfDrawing::kLinesMax;
  EXPECT_EQ(flatten(blocks, model).lines.size(), DxfDrawing::kLinesMax);
  EXPECT_TRUE(flatten(blocks, model).remarks.empty());
  ++model.inserts[0].rows;
  const Flat flat = flatten(blocks, model);
  EXPECT_EQ(flat.lines.size(), DxfDrawing::kLinesMax);
  ASSERT_EQ(flat.remarks.size(), 1U);
  EXPECT_EQ(flat.remarks[0], "the drawing has more than 20000 lines: the rest is left out");
}

// A thousand blocks each 16 deep, and a field of nothing without end.
TEST(DxfBlocks, StepsAreBounded) {
  DxfBlocks blocks;
  DxfContent model = chain(blocks, DxfBlocks::kDepthMax, 1000);
  blocks.add("b15")->strokes = {};
  Flat flat = flatten(blocks, model);
  EXPECT_TRUE(flat.lines.empty());
  const std::vector<std::string> expected = {
      "its blocks are inserted too often: the rest is left out"};
  EXPECT_EQ(flat.remarks, expected);
  blocks.add("nothing");
  model.inserts = {insert_of("nothing")};
  model.inserts[0].rows = model.inserts[0].columns = 2'000'000'000;
  EXPECT_EQ(flatten(blocks, model).remarks, expected);
  model.inserts[0].rows = 1000;
  model.inserts[0].columns = 1000;
  EXPECT_TRUE(flatten(blocks, model).remarks.empty());
}

TEST(DxfBlocks, WhatGetsTooFarAwayIsLeftOut) {
  DxfBlocks blocks;
  DxfContent model = chain(blocks, DxfBlocks::kDepthMax, 1);
  for (int i = 0; i + 1 < DxfBlocks::kDepthMax; ++i)
    blocks.add("b" + std::to_string(i))->inserts = {
        insert_of("b" + std::to_string(i + 1), DxfPlace::scaled(1e9, -1e9))};
  const Flat flat = flatten(blocks, model);
  EXPECT_TRUE(flat.lines.empty());
  ASSERT_EQ(flat.remarks.size(), 1U);
  EXPECT_EQ(flat.remarks[0], "lines more than 1e9 units away are left out");
}

TEST(DxfBlocks, AreBoundedInNumber) {
  DxfBlocks blocks;
  for (std::size_t i = 0; i < DxfBlocks::kBlocksMax; ++i)
    ASSERT_NE(blocks.add(std::to_string(i)), nullptr);
  EXPECT_EQ(blocks.add("one more"), nullptr);
  EXPECT_NE(blocks.add("5"), nullptr) << "replaced";
}

}  // namespace dxf_blocks_test

}  // namespace rack
