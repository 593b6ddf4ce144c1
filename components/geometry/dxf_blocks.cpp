#include "components/geometry/dxf_blocks.h"

#include <cmath>
#include <utility>

#include "base/text.h"

namespace rack {

DxfPlace DxfPlace::rotated(double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {.xx = c, .xy = -s, .yx = s, .yy = c};
}

DxfPoint DxfPlace::operator()(const DxfPoint& point) const {
  return {xx * point.x + xy * point.y + x, yx * point.x + yy * point.y + y};
}

DxfPlace DxfPlace::operator*(const DxfPlace& inner) const {
  const DxfPoint at = (*this)({inner.x, inner.y});
  return {.xx = xx * inner.xx + xy * inner.yx,
          .xy = xx * inner.xy + xy * inner.yy,
          .x = at.x,
          .yx = yx * inner.xx + yy * inner.yx,
          .yy = yx * inner.xy + yy * inner.yy,
          .y = at.y};
}

DxfContent* DxfBlocks::add(std::string_view name) {
  const std::string key = tims::base::lower(name);
  if (blocks_.size() == kBlocksMax && !blocks_.contains(key)) return nullptr;
  Block& block = blocks_[key];
  block = {};
  return &block.content;
}

class DxfBlocks::Flattening {
 public:
  Flattening(DxfBlocks& blocks, DxfLayers& layers, DxfRemarks& remarks)
      : blocks_(blocks), layers_(layers), remarks_(remarks) {}

  void draw(const DxfContent& content, const Context& context) {
    for (const DxfStroke& stroke : content.strokes)
      if (!draw(stroke, context)) return;
    for (const DxfInsert& insert : content.inserts)
      if (!draw(insert, context)) return;
  }

  std::vector<DxfLine> lines() && { return std::move(lines_); }

 private:
  // False: nothing more is drawn.
  bool draw(const DxfStroke& stroke, const Context& context) {
    if (!step()) return false;
    DxfLine line{context.place(stroke.line.from), context.place(stroke.line.to), stroke.line.layer};
    if (stroke.is_of_layer_0) line.layer = context.layer;
    if (!layers_.takes(line.layer)) return true;
    line.layer = layers_.number(line.layer);
    if (!is_near(line.from) || !is_near(line.to)) {
      if (!std::exchange(has_far_, true))
        remarks_.add(0, "lines more than 1e9 units away are left out");
      return true;
    }
    if (lines_.size() == DxfDrawing::kLinesMax)
      return full("the drawing has more than 20000 lines");
    lines_.push_back(line);
    return true;
  }

  bool draw(const DxfInsert& insert, const Context& context) {
    const auto skip = [&](std::string_view why) {
      remarks_.add(insert.line, "INSERT",
                   "of block \"" + DxfRemarks::named(insert.block) + "\" " + std::string(why));
      return true;
    };
    const auto found = blocks_.blocks_.find(tims::base::lower(insert.block));
    if (found == blocks_.blocks_.end()) return skip("which the drawing does not contain");
    Block& block = found->second;
    if (block.content.is_external) return skip("which is in another file: bind it");
    if (block.is_open) return skip("in itself");
    if (context.depth == kDepthMax) return skip("within 16 other blocks");
    block.is_open = true;
    draw_all(insert, block.content, context);
    block.is_open = false;
    return !is_full_;
  }

  void draw_all(const DxfInsert& insert, const DxfContent& content, const Context& context) {
    const DxfPlace base = DxfPlace::moved({-content.base.x, -content.base.y});
    const std::int32_t layer = insert.is_of_layer_0 ? context.layer : insert.layer;
    for (std::int64_t row = 0; row < insert.rows; ++row)
      for (std::int64_t column = 0; column < insert.columns; ++column) {
        if (!step()) return;
        const auto r = static_cast<double>(row);
        const auto c = static_cast<double>(column);
        const DxfPlace cell = DxfPlace::moved({c * insert.column_step.x + r * insert.row_step.x,
                                               c * insert.column_step.y + r * insert.row_step.y});
        draw(content, {context.place * cell * insert.place * base, layer, context.depth + 1});
      }
  }

  static bool is_near(const DxfPoint& point) {
    return std::abs(point.x) <= DxfDrawing::kFarthest && std::abs(point.y) <= DxfDrawing::kFarthest;
  }

  bool step() {
    return !is_full_ && (++steps_ <= kStepsMax || full("its blocks are inserted too often"));
  }
  bool full(std::string_view why) {
    is_full_ = true;
    remarks_.add(0, std::string(why) + ": the rest is left out");
    return false;
  }

  DxfBlocks& blocks_;
  DxfLayers& layers_;
  DxfRemarks& remarks_;
  std::vector<DxfLine> lines_;
  std::size_t steps_ = 0;
  bool is_full_ = false;
  bool has_far_ = false;
};

std::vector<DxfLine> DxfBlocks::flatten(const DxfContent& model, DxfLayers& layers,
                                        DxfRemarks& remarks) {
  Flattening flattening(*this, layers, remarks);
  flattening.draw(model, {});
  return std::move(flattening).lines();
}

}  // namespace rack
