#include "components/localisation/floor_plan.h"

#include <utility>

#include <fmt/core.h>

#include "base/text.h"
#include "components/localisation/outlines.h"
#include "components/localisation/ros_map.h"
#include "components/localisation/ros_yaml.h"

namespace rack::localisation {

namespace {

tims::Error in_file(const std::string& path, const tims::Error& error) {
  return {error.code(), path + ": " + error.detail()};
}

// The path of a file that another file names relative to itself.
std::string beside(const std::string& path, const std::string& name) {
  const auto folder_end = path.rfind('/');
  const bool is_relative = !name.starts_with('/') && folder_end != std::string::npos;
  return is_relative ? path.substr(0, folder_end + 1) + name : name;
}

tims::Result<FloorPlan> read_drawing(const std::string& path, const PlanPlacement& placement,
                                     std::string_view text) {
  if (text.starts_with("\x89PNG") || text.starts_with("P5") || text.starts_with("P2"))
    return tims::Error(tims::Errc::kMalformed,
                       path + ": a picture without scale: use the .yaml file that describes it");
  auto drawing = read_plan(path, text, placement);
  if (!drawing) return drawing.error();
  FloorPlan plan{.path = path, .drawing = std::move(*drawing)};
  plan.remarks = std::exchange(plan.drawing.drawing.remarks, {});
  return plan;
}

tims::Result<FloorPlan> read_ros_map(const std::string& path, const MapSources& sources,
                                     std::string_view text) {
  const auto info = read_ros_yaml(text);
  if (!info) return in_file(path, info.error());
  const std::string image = beside(path, info->image);
  const auto picture = sources.read_file(image);
  if (!picture)
    return tims::Error(picture.error().code(),
                       fmt::format("{}: its image: {}", path, picture.error().detail()));
  const auto values = sources.decode(*picture);
  if (!values) return in_file(image, values.error());
  FloorPlan plan{.path = path, .cells = grid_of(*info, *values)};
  for (const std::string& remark : info->remarks)
    plan.remarks.push_back(fmt::format("{}, {}", path, remark));
  return plan;
}

}  // namespace

bool is_ros_map(std::string_view path) {
  const std::string name = tims::base::lower(path);
  return name.ends_with(".yaml") || name.ends_with(".yml");
}

tims::Result<FloorPlan> read_floor_plan(const std::string& path, const PlanPlacement& placement,
                                        const MapSources& sources) {
  const auto text = sources.read_file(path);
  if (!text) return text.error();
  return is_ros_map(path) ? read_ros_map(path, sources, *text)
                          : read_drawing(path, placement, *text);
}

tims::Result<DxfPlan> lines_of(FloorPlan plan) {
  if (!plan.cells) {
    plan.drawing.drawing.remarks = std::move(plan.remarks);
    return std::move(plan.drawing);
  }
  const auto walls = outlines(*plan.cells, DxfDrawing::kLinesMax);
  if (!walls) return in_file(plan.path, walls.error());
  DxfPlan made{.placement = {.scale = 1}};
  made.drawing.unit = 1;
  made.drawing.remarks = std::move(plan.remarks);
  if (walls->is_coarse)
    made.drawing.remarks.push_back(
        fmt::format("{}: the walls are simplified to lines within {:.0f} mm, since they would be "
                    "more than {} lines",
                    plan.path, walls->error, DxfDrawing::kLinesMax));
  made.drawing.lines.reserve(walls->lines.size());
  for (const auto& [from, to] : walls->lines)  // a drawing has x to the east
    made.drawing.lines.push_back({{from.y, from.x}, {to.y, to.x}});
  return made;
}

tims::Result<GridMap> cells_of(FloorPlan plan, double resolution) {
  if (plan.cells) return std::move(*plan.cells);
  const PlanPlacement& at = plan.drawing.placement;
  auto map = read_map(plan.drawing.drawing, at.scale, at.offset_x, at.offset_y, resolution);
  if (!map) return in_file(plan.path, map.error());
  return map;
}

}  // namespace rack::localisation
