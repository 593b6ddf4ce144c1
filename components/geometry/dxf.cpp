#include "components/geometry/dxf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include <dxflib/dl_creationadapter.h>
#include <dxflib/dl_dxf.h>
#include <fmt/core.h>

#include "base/text.h"
#include "components/geometry/dxf_blocks.h"
#include "components/geometry/dxf_curves.h"
#include "components/geometry/dxf_entity.h"
#include "components/geometry/dxf_layers.h"
#include "components/geometry/dxf_remarks.h"
#include "components/geometry/dxf_units.h"
#include "components/geometry/pose.h"

namespace rack {

namespace {

constexpr std::size_t kStrokesMax = 200'000;  // lines of all blocks together
constexpr std::size_t kInsertsMax = 100'000;
constexpr double kTilt = 1e-6;  // of the extrusion; for the length 1

constexpr std::array<std::string_view, 7> kDrawn = {"LINE",    "POINT",      "ARC",   "CIRCLE",
                                                    "ELLIPSE", "LWPOLYLINE", "INSERT"};
// Types that may be walls; texts, dimensions, hatches and the like are none.
constexpr std::array<std::string_view, 14> kUnread = {
    "SPLINE", "MLINE", "SOLID", "TRACE", "3DFACE",  "3DSOLID", "REGION",
    "BODY",   "MESH",  "HELIX", "XLINE", "SURFACE", "RAY",     "WIPEOUT"};

struct DxfPolyline {
  int flags = 0;
  DL_Attributes attributes{};
  std::optional<int> side{};
  std::vector<DL_VertexData> vertices{};

  [[nodiscard]] std::vector<DxfPoint> points() const {
    constexpr int kClosed = 1;
    std::vector<DxfPoint> points;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const DxfPoint to{vertices[i].x, vertices[i].y};
      if (i == 0) {
        points.push_back(to);
      } else {
        add_bulge({vertices[i - 1].x, vertices[i - 1].y}, to, vertices[i - 1].bulge, points);
      }
    }
    if ((flags & kClosed) != 0 && vertices.size() > 1) {
      const DL_VertexData& last = vertices.back();
      // Back on the same line is no second wall.
      if (vertices.size() > 2 || last.bulge != 0)
        add_bulge({last.x, last.y}, points.front(), last.bulge, points);
    }
    return points;
  }
};

// Takes what dxflib has read of one entity after the other.
class DxfBuilder : public DL_CreationAdapter {
 public:
  DxfBuilder(DxfDrawing& drawing, DxfLayers& layers, DxfRemarks& remarks)
      : drawing_(drawing), layers_(layers), remarks_(remarks) {}

  void begin(const DxfEntity& entity) {
    line_ = entity.line;
    type_ = entity.type;
  }
  [[nodiscard]] bool is_in_block() const { return block_ != nullptr; }
  void leave_block() { block_ = nullptr; }

  void end() {
    drawing_.lines = blocks_.flatten(model_, layers_, remarks_);
    layers_.report(remarks_);
  }

  // --- tables

  void setVariableInt(const std::string& key, int value, int /*code*/) override {
    if (key != "$INSUNITS" || value == 0) return;
    drawing_.unit = dxf_unit_length(value);
    if (drawing_.unit == 0)
      remarks_.add(line_, fmt::format("$INSUNITS {} is not known as a unit of floor plans", value));
  }

  void addLayer(const DL_LayerData& data) override {
    constexpr int kFrozen = 1;
    layers_.index(data.name);
    if ((data.flags & kFrozen) != 0 || attributes.getColor() < 0) layers_.hide(data.name);
  }

  void addBlock(const DL_BlockData& data) override {
    constexpr int kExternal = 4 | 8;
    block_ = blocks_.add(data.name);
    if (block_ == nullptr) return skip("and those after it: too many blocks");
    block_->base = {data.bpx, data.bpy};
    block_->is_external = (data.flags & kExternal) != 0;
  }
  void endBlock() override { leave_block(); }

  // --- entities

  void addPoint(const DL_PointData& data) override { add({{data.x, data.y}, {data.x, data.y}}); }

  void addLine(const DL_LineData& data) override { add({{data.x1, data.y1}, {data.x2, data.y2}}); }

  void addArc(const DL_ArcData& data) override {
    if (!(data.radius > 0)) return skip("has no radius of more than 0");
    const double first = radians(data.angle1);
    add_in_plane(chords(dxf_circle({data.cx, data.cy}, data.radius), first,
                        dxf_sweep(first, radians(data.angle2))));
  }

  void addCircle(const DL_CircleData& data) override {
    if (!(data.radius > 0)) return skip("has no radius of more than 0");
    add_in_plane(chords(dxf_circle({data.cx, data.cy}, data.radius), 0, 2 * kPi));
  }

  // The coordinates are those of the drawing, also of one on the back of the plane.
  void addEllipse(const DL_EllipseData& data) override {
    const auto side = side_of_plane();
    if (!side) return skip_tilted();
    const double ratio = *side * data.ratio;
    add(chords({{data.cx, data.cy}, {data.mx, data.my}, {-data.my * ratio, data.mx * ratio}},
               data.angle1, dxf_sweep(data.angle1, data.angle2)));
  }

  void addPolyline(const DL_PolylineData& data) override {
    polyline_.emplace();
    polyline_->flags = static_cast<int>(data.flags);
    polyline_->attributes = attributes;
    polyline_->side = side_of_plane();
  }
  void addVertex(const DL_VertexData& data) override {
    if (polyline_) polyline_->vertices.push_back(data);
  }
  void endEntity() override {
    if (!polyline_) return;
    const DxfPolyline polyline = *std::exchange(polyline_, std::nullopt);
    attributes = polyline.attributes;  // of its last vertex until now
    constexpr int kSpace = 8;
    const bool is_in_space = (polyline.flags & kSpace) != 0;
    if (!polyline.side && !is_in_space) return skip_tilted();
    auto points = polyline.points();
    if (!is_in_space && *polyline.side < 0) mirror(points);
    add(points);
  }
  void endSequence() override { endEntity(); }

  void addInsert(const DL_InsertData& data) override {
    const auto side = side_of_plane();
    if (!side) return skip_tilted();
    if (!is_shown()) return;
    if (++inserts_ > kInsertsMax) return skip("and those after it: too many");
    const DxfPlace front = *side < 0 ? DxfPlace::mirrored() : DxfPlace();
    const DxfPlace turned = front * DxfPlace::rotated(radians(data.angle));
    content().inserts.push_back({.block = data.name,
                                 .line = line_,
                                 .place = front * DxfPlace::moved({data.ipx, data.ipy}) *
                                          DxfPlace::rotated(radians(data.angle)) *
                                          DxfPlace::scaled(data.sx, data.sy),
                                 .columns = std::max(data.cols, 1),
                                 .rows = std::max(data.rows, 1),
                                 .column_step = turned({data.colSp, 0}),
                                 .row_step = turned({0, data.rowSp}),
                                 .layer = layer(),
                                 .is_of_layer_0 = is_on_layer_0_of_block()});
  }

 private:
  DxfContent& content() { return block_ != nullptr ? *block_ : model_; }
  [[nodiscard]] std::int32_t layer() const { return layers_.index(attributes.getLayer()); }
  [[nodiscard]] bool is_on_layer_0_of_block() const {
    return block_ != nullptr && attributes.getLayer() == "0";
  }

  bool is_shown() { return is_on_layer_0_of_block() || layers_.shows(layer()); }

  // 1: drawn on the front of the plane of the plan, -1: on its back. Nothing: in another plane.
  [[nodiscard]] std::optional<int> side_of_plane() const {
    const double* const normal = extrusion->getDirection();
    const double across = std::hypot(normal[0], normal[1]);
    if (!(across <= kTilt * std::abs(normal[2])) || normal[2] == 0) return std::nullopt;
    return normal[2] < 0 ? -1 : 1;
  }

  // Of an entity with coordinates in its own plane. On the back, x runs the other way.
  void add_in_plane(std::vector<DxfPoint> points) {
    const auto side = side_of_plane();
    if (!side) return skip_tilted();
    if (*side < 0) mirror(points);
    add(points);
  }
  static void mirror(std::vector<DxfPoint>& points) {
    for (DxfPoint& point : points) point.x = -point.x;
  }

  void add(const std::vector<DxfPoint>& points) {
    if (!is_shown() || points.size() < 2) return;
    if (strokes_ + points.size() - 1 > kStrokesMax)
      return skip("does not fit: its blocks have more than 200000 lines");
    strokes_ += points.size() - 1;
    const bool is_of_layer_0 = is_on_layer_0_of_block();
    for (std::size_t i = 1; i < points.size(); ++i)
      content().strokes.push_back({{points[i - 1], points[i], layer()}, is_of_layer_0});
  }

  void skip(std::string_view why) { remarks_.add(line_, type_, why); }
  void skip_tilted() { skip("is drawn in a tilted plane: flatten the drawing"); }

  DxfDrawing& drawing_;
  DxfLayers& layers_;
  DxfRemarks& remarks_;
  DxfContent model_;
  DxfBlocks blocks_;
  DxfContent* block_ = nullptr;  // that is being defined
  std::optional<DxfPolyline> polyline_;
  std::size_t strokes_ = 0;
  std::size_t inserts_ = 0;
  std::size_t line_ = 0;  // of the entity
  std::string_view type_;
};

// Passes to dxflib the entities that it is to read, each by itself. So each has its line number
// when it is reported, and none is taken to continue another one.
class DxfReader {
 public:
  explicit DxfReader(std::string_view layers) : layers_(layers) {
    std::istringstream nothing;
    dxf_.in(nothing, &builder_);  // prepares it for the first group
  }

  void take(const DxfEntity& entity) {
    if (polyline_) {
      if (entity.type == "VERTEX") return vertex(entity);
      finish_polyline(entity.type == "SEQEND");
    }
    if (entity.type == "SECTION" || entity.type == "ENDSEC") {
      section_ = entity.type == "SECTION" ? entity.value(2) : std::string_view{};
      builder_.leave_block();
    } else if (section_ == "HEADER") {
      if (entity.type == "$INSUNITS") read(entity);
    } else if (section_ == "TABLES") {
      if (entity.type == "LAYER") read(entity);
    } else if (section_ == "BLOCKS" && (entity.type == "BLOCK" || entity.type == "ENDBLK")) {
      builder_.leave_block();
      read(entity);
    } else if (section_.empty() || section_ == "ENTITIES" || builder_.is_in_block()) {
      drawn(entity);
    }
  }

  DxfDrawing end() {
    if (polyline_) finish_polyline(false);
    for (const auto& [type, found] : unread_)
      if (found.line > 0)
        remarks_.add(found.line, type,
                     fmt::format("is not read ({} of them): use polylines", found.count));
    report_left_out();
    builder_.end();
    drawing_.remarks = remarks_.texts();
    return std::move(drawing_);
  }

 private:
  void drawn(const DxfEntity& entity) {
    const std::string_view type = entity.type;
    if (type == "SEQEND") return;  // of the texts of an INSERT
    if (type == "VERTEX") return remarks_.add(entity.line, type, "without POLYLINE");
    const bool is_left_out = leaves_out(entity);
    if (type == "POLYLINE") {
      polyline_ = {entity};
      polyline_fault_ = entity.fault();
      is_polyline_left_out_ = is_left_out;
    } else if (is_left_out) {
      return;
    } else if (std::ranges::find(kDrawn, type) != kDrawn.end()) {
      read(entity);
    } else {
      ++drawing_.others;
      const bool may_be_wall = std::ranges::find(kUnread, type) != kUnread.end();
      const bool is_known = unread_.contains(type) || unread_.size() < kTypesMax;
      auto& found = unread_[is_known ? type : kOtherTypes];
      if (++found.count == 1 && may_be_wall && is_known) found.line = entity.line;
    }
  }

  // Counts what cannot be seen in the plan.
  bool leaves_out(const DxfEntity& entity) {
    const bool is_in_paper_space = entity.number(67, 0) == 1;
    const bool is_invisible = entity.number(60, 0) == 1;
    if (!is_in_paper_space && !is_invisible) return false;
    ++(is_in_paper_space ? in_paper_space_ : invisible_);
    ++drawing_.others;
    return true;
  }

  void report_left_out() {
    if (in_paper_space_ > 0)
      remarks_.add(0, fmt::format("{} entities in the paper space are left out", in_paper_space_));
    if (invisible_ > 0)
      remarks_.add(0, fmt::format("{} invisible entities are left out", invisible_));
    std::string types;
    for (const auto& [type, found] : unread_)
      if (found.line == 0)
        types += fmt::format("{}{} {}", types.empty() ? "" : ", ", found.count,
                             DxfRemarks::named(type, kTypeNameMax));
    if (!types.empty())
      remarks_.add(0, fmt::format("left out, since they are not lines of walls: {}", types));
  }

  void vertex(const DxfEntity& entity) {
    constexpr int kFrame = 16;  // of a spline: not on the line
    if ((entity.number(70, 0) & kFrame) != 0 || !polyline_fault_.empty()) return;
    polyline_fault_ = entity.fault();
    if (polyline_->size() > DxfEntity::kVerticesMax)
      polyline_fault_ = "has more than 20000 vertices";
    polyline_->push_back(entity);
  }

  void finish_polyline(bool has_end) {
    const std::vector<DxfEntity> parts = *std::exchange(polyline_, std::nullopt);
    if (is_polyline_left_out_) return;
    const DxfEntity& polyline = parts.front();
    if (!polyline_fault_.empty())
      return remarks_.add(polyline.line, polyline.type, polyline_fault_);
    if (!has_end) remarks_.add(polyline.line, polyline.type, "without SEQEND");
    builder_.begin(polyline);
    for (const DxfEntity& part : parts) pass(part);
    pass({.type = "SEQEND"});
    pass({.type = kFlush});
  }

  void read(const DxfEntity& entity) {
    const std::string fault = entity.fault();
    if (!fault.empty()) return remarks_.add(entity.line, entity.type, fault);
    builder_.begin(entity);
    pass(entity);
    pass({.type = kFlush});
  }

  // dxflib reports an entity when it sees the next one.
  void pass(const DxfEntity& entity) {
    const std::string text = entity.text();
    groups_.clear();
    groups_.str(text);
    for (auto lines = std::ranges::count(text, '\n'); lines > 0; lines -= 2)
      dxf_.readDxfGroups(groups_, &builder_);
  }

  struct Unread {
    std::size_t line = 0;  // of the first one; 0: they are not walls
    std::size_t count = 0;
  };
  static constexpr std::size_t kTypesMax = 30;
  static constexpr std::size_t kTypeNameMax = 20;
  static constexpr std::string_view kOtherTypes = "of other types";
  static constexpr std::string_view kFlush = "ENDSEC";

  DxfDrawing drawing_;
  DxfLayers layers_;
  DxfRemarks remarks_;
  DxfBuilder builder_{drawing_, layers_, remarks_};
  DL_Dxf dxf_;
  std::istringstream groups_;
  std::string_view section_;
  std::optional<std::vector<DxfEntity>> polyline_;  // POLYLINE and its VERTEXes
  std::string polyline_fault_;
  bool is_polyline_left_out_ = false;
  std::size_t in_paper_space_ = 0;
  std::size_t invisible_ = 0;
  std::map<std::string_view, Unread> unread_;
};

}  // namespace

tims::Result<DxfDrawing> read_dxf(std::string_view text, std::string_view layers) {
  const auto refused = [](const char* why) { return tims::Error(tims::Errc::kMalformed, why); };
  if (text.starts_with("AutoCAD Binary DXF")) return refused("binary DXF: save it as text");
  if (text.starts_with("AC10")) return refused("a DWG drawing: save it as DXF");
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    return refused("UTF-16: save it as DXF in UTF-8 or ASCII");
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  DxfEntities entities(text);
  DxfReader reader(layers);
  for (;;) {
    const auto entity = entities.next();
    if (!entity) return entity.error();
    if (!*entity) return reader.end();
    reader.take(**entity);
  }
}

namespace {

// The reasons why a drawing has no lines.
tims::Error nothing_left(const std::vector<std::string>& remarks) {
  constexpr std::size_t kReasonsMax = 4;
  std::string text = "no lines";
  for (std::size_t i = 0; i < std::min(remarks.size(), kReasonsMax); ++i)
    text += (i == 0 ? ": " : "; ") + remarks[i];
  return {tims::Errc::kMalformed, text};
}

}  // namespace

tims::Result<DxfPlan> read_plan(std::string_view name, std::string_view text,
                                const PlanPlacement& wanted) {
  const auto in_plan = [&](const tims::Error& error) {
    return tims::Error(error.code(), std::string(name) + ": " + error.detail());
  };
  auto drawing = read_dxf(text, wanted.layers);
  if (!drawing) return in_plan(drawing.error());
  if (drawing->lines.empty() && !drawing->remarks.empty())
    return in_plan(nothing_left(drawing->remarks));
  PlanPlacement placement = wanted;
  if (wanted.scale == 0 && drawing->unit == 0 && wanted.scale_otherwise > 0) {
    placement.scale = wanted.scale_otherwise;
    drawing->remarks.push_back(fmt::format(
        "it does not state its unit ($INSUNITS): read with {} mm per unit", placement.scale));
  }
  const auto scale = drawing->scale(placement.scale);
  if (!scale) return in_plan(scale.error());
  placement.scale = *scale;
  for (std::string& remark : drawing->remarks) remark.insert(0, std::string(name) + ", ");
  return DxfPlan{std::move(*drawing), std::move(placement)};
}

}  // namespace rack
