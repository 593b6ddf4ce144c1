#include "components/localisation/line_map.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "components/geometry/dxf_units.h"

namespace rack::localisation {

namespace {

constexpr double kLineMapFarthest = 1e9;  // mm

tims::Error wrong(std::string what) { return {tims::Errc::kInvalidArgument, std::move(what)}; }

// Length and direction are computed from the end points; the values of the sender are ignored.
FeatureMapDataPoint completed(FeatureMapDataPoint line) {
  const double dx = line.x2 - line.x;
  const double dy = line.y2 - line.y;
  const double rho = heading(std::atan2(dy, dx));
  line.l = std::hypot(dx, dy);
  line.rho = rho;
  line.sin = std::sin(rho);
  line.cos = std::cos(rho);
  line.type = FeatureMapDataPoint::kLine;
  return line;
}

bool is_line(const FeatureMapDataPoint& line) {
  for (const double value : {line.x.raw(), line.y.raw(), line.x2.raw(), line.y2.raw()})
    if (!(std::abs(value) <= kLineMapFarthest)) return false;
  return true;
}

double distance(const FeatureMapDataPoint& line, const Pose& from) {
  const double dx = from.x - line.x;
  const double dy = from.y - line.y;
  const double along = std::clamp(dx * line.cos + dy * line.sin, 0.0, line.l.raw());
  return std::hypot(dx - along * line.cos, dy - along * line.sin);
}

}  // namespace

LineMap::LineMap() : layers_(kLayers, true) { order_.reserve(kLinesMax); }

LineMap::LineMap(const DxfPlan& plan) : LineMap() {
  const PlanPlacement& at = plan.placement;
  for (const DxfLine& line : plan.drawing.lines) {
    const FeatureMapDataPoint read{.x = (line.from.y - at.offset_x) * at.scale,
                                   .y = (line.from.x - at.offset_y) * at.scale,
                                   .x2 = (line.to.y - at.offset_x) * at.scale,
                                   .y2 = (line.to.x - at.offset_y) * at.scale,
                                   .layer = std::clamp(line.layer, 0, kLayers - 1)};
    if (!add(read)) ++left_out_;
  }
}

std::string LineMap::to_dxf(const PlanPlacement& placement) const {
  std::string text = fmt::format(
      "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n{}\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n",
      dxf_unit(placement.scale));
  for (const FeatureMapDataPoint& line : lines_)
    text += fmt::format("0\nLINE\n8\n{}\n10\n{:.6f}\n20\n{:.6f}\n11\n{:.6f}\n21\n{:.6f}\n",
                        line.layer, line.y.raw() / placement.scale + placement.offset_y,
                        line.x.raw() / placement.scale + placement.offset_x,
                        line.y2.raw() / placement.scale + placement.offset_y,
                        line.x2.raw() / placement.scale + placement.offset_x);
  return text + "0\nENDSEC\n0\nEOF\n";
}

tims::Result<void> LineMap::add(const FeatureMapDataPoint& line) {
  if (!is_line(line)) return wrong("the ends of the line are not valid coordinates");
  if (line.layer < 0 || line.layer >= kLayers) return wrong("the layer must be 0 to 19");
  if (lines_.size() == kLinesMax) return wrong("the map is full");
  lines_.push_back(completed(line));
  return {};
}

tims::Result<std::size_t> LineMap::at(i32 place) const {
  if (place < 0 || static_cast<std::size_t>(place) >= order_.size())
    return wrong("the newest data set has no line " + std::to_string(place));
  return order_[static_cast<std::size_t>(place)];
}

tims::Result<void> LineMap::erase(i32 place) {
  const auto line = at(place);
  if (!line) return line.error();
  if (*line >= lines_.size()) return wrong("that line was erased");
  lines_.erase(lines_.begin() + static_cast<std::ptrdiff_t>(*line));
  // The other lines keep their indices in the data set that the editor has.
  order_[static_cast<std::size_t>(place)] = kLinesMax;
  for (std::size_t& other : order_)
    if (other != kLinesMax && other > *line) --other;
  return {};
}

tims::Result<void> LineMap::displace(i32 place, const FeatureMapDataPoint& to) {
  const auto line = at(place);
  if (!line) return line.error();
  if (*line >= lines_.size()) return wrong("that line was erased");
  if (!is_line(to)) return wrong("the ends of the line are not valid coordinates");
  FeatureMapDataPoint moved = to;
  moved.layer = lines_[*line].layer;
  lines_[*line] = completed(moved);
  return {};
}

FeatureMapLayerData LineMap::layers() const {
  FeatureMapLayerData data;
  for (i32 layer = 0; layer < kLayers; ++layer)
    if (layers_[static_cast<std::size_t>(layer)]) data.layers.push_back(layer);
  return data;
}

void LineMap::show(const FeatureMapLayerData& layers) {
  layers_.assign(kLayers, false);
  for (const i32 layer : layers.layers)
    if (layer >= 0 && layer < kLayers) layers_[static_cast<std::size_t>(layer)] = true;
}

bool LineMap::shown(const FeatureMapDataPoint& line) const {
  return layers_[static_cast<std::size_t>(line.layer)];
}

void LineMap::fill(const Pose& robot, FeatureMapData& data) {
  order_.clear();
  for (std::size_t i = 0; i < lines_.size(); ++i)
    if (shown(lines_[i])) order_.push_back(i);
  constexpr std::size_t kMost = decltype(data.features)::kMax;
  if (order_.size() > kMost) {
    const auto end = order_.begin() + static_cast<std::ptrdiff_t>(kMost);
    std::ranges::nth_element(order_, end - 1, {},
                             [&](std::size_t line) { return distance(lines_[line], robot); });
    order_.erase(end, order_.end());
    std::ranges::sort(order_);
  }
  data.pos = robot.position();
  data.features.clear();
  for (const std::size_t line : order_) data.features.push_back(lines_[line]);
}

}  // namespace rack::localisation
