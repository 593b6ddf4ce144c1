#include "components/position/map_file.h"

#include <filesystem>
#include <system_error>

#include "components/localisation/ros_map.h"
#include "components/position/map_picture.h"
#include "os/file.h"

namespace rack::navigation {

namespace {

tims::Error in_file(const std::string& path, const tims::Error& error) {
  return {error.code(), path + ": " + error.detail()};
}

tims::Result<LoadedMap> load_plan(const std::string& path, std::string_view text,
                                  const PlanPlacement& placement) {
  auto plan = read_plan(path, text, placement.scale);
  if (!plan) return plan.error();
  auto map = localisation::read_map(plan->drawing, plan->scale, placement.offset_x,
                                    placement.offset_y, placement.resolution);
  if (!map) return in_file(path, map.error());
  return LoadedMap{.map = std::move(*map), .remarks = std::move(plan->drawing.remarks)};
}

}  // namespace

tims::Result<LoadedMap> load_map(const std::string& path, const PlanPlacement& placement) {
  const auto text = tims::os::read_file(path);
  if (!text) return text.error();
  if (!path.ends_with(".yaml") && !path.ends_with(".yml")) return load_plan(path, *text, placement);
  const auto info = localisation::read_ros_yaml(*text);
  if (!info) return in_file(path, info.error());
  const std::string image = std::filesystem::path(path).parent_path() / info->image;
  const auto picture = tims::os::read_file(image);
  if (!picture) return picture.error();
  const auto cells = read_map_picture(*picture);
  if (!cells) return in_file(image, cells.error());
  return LoadedMap{.map = localisation::grid_of(*info, *cells)};
}

}  // namespace rack::navigation
