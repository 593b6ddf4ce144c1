// The blocks of a drawing, and the lines that result when each INSERT is replaced by its block.
//
// Some bytes of a file can ask for more lines than memory holds: a block of blocks of blocks, or an
// INSERT with a million rows. So nesting, lines, and the steps taken in all are bounded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "components/geometry/dxf.h"
#include "components/geometry/dxf_layers.h"
#include "components/geometry/dxf_remarks.h"

namespace rack {

// An affine map of the plane.
struct DxfPlace {
  double xx = 1, xy = 0, x = 0;  // new x = xx * x + xy * y + x
  double yx = 0, yy = 1, y = 0;

  // A mirror image in x, as entities have that are drawn on the back of the plane.
  static DxfPlace mirrored() { return {.xx = -1}; }
  static DxfPlace moved(const DxfPoint& by) { return {.x = by.x, .y = by.y}; }
  static DxfPlace scaled(double x, double y) { return {.xx = x, .yy = y}; }
  static DxfPlace rotated(double angle);  // counter-clockwise

  [[nodiscard]] DxfPoint operator()(const DxfPoint& point) const;
  [[nodiscard]] DxfPlace operator*(const DxfPlace& inner) const;
};

struct DxfInsert {
  std::string block;  // as written
  std::size_t line = 0;
  DxfPlace place;  // of the block's base point
  std::int64_t columns = 1;
  std::int64_t rows = 1;
  DxfPoint column_step{};
  DxfPoint row_step{};
  std::int32_t layer = 0;  // index of DxfLayers
  bool is_of_layer_0 = false;
};

struct DxfStroke {
  DxfLine line;  // its layer is an index of DxfLayers
  // In a block, what is on layer 0 gets the layer of the INSERT.
  bool is_of_layer_0 = false;
};

// The model space, or a block.
struct DxfContent {
  DxfPoint base{};
  bool is_external = false;  // a reference to another file
  std::vector<DxfStroke> strokes{};
  std::vector<DxfInsert> inserts{};
};

class DxfBlocks {
 public:
  static constexpr std::size_t kBlocksMax = 10'000;
  static constexpr int kDepthMax = 16;                 // blocks within blocks
  static constexpr std::size_t kStepsMax = 1'000'000;  // lines and blocks that are inserted

  // Names differ by more than upper and lower case. A name that is there gets a new block. Nothing:
  // there are too many. It stays valid when others are added.
  DxfContent* add(std::string_view name);

  // All lines of the model space and its blocks on layers that are chosen, at most
  // DxfDrawing::kLinesMax.
  std::vector<DxfLine> flatten(const DxfContent& model, DxfLayers& layers, DxfRemarks& remarks);

 private:
  struct Block {
    DxfContent content{};
    bool is_open = false;  // is being inserted
  };
  // Where a content is drawn.
  struct Context {
    DxfPlace place{};
    std::int32_t layer = 0;
    int depth = 0;
  };
  class Flattening;

  std::map<std::string, Block, std::less<>> blocks_;
};

}  // namespace rack
