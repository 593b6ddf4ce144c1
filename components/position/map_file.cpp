#include "components/position/map_file.h"

#include <filesystem>
#include <system_error>

#include "components/localisation/ros_map.h"
#include "components/position/map_picture.h"
#include "os/file.h"

namespace rack::navigation {

namespace {

constexpr std::size_t kDescriptionBytesMax = 1 << 20;
constexpr std::size_t kImageBytesMax = 256 << 20;  // more than the largest map, uncompressed

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
  const bool is_plan = !path.ends_with(".yaml") && !path.ends_with(".yml");
  const auto text = tims::os::read_file(path, is_plan ? kPlanBytesMax : kDescriptionBytesMax);
  if (!text) return text.error();
  if (is_plan) return load_plan(path, *text, placement);
  const auto info = localisation::read_ros_yaml(*text);
  if (!info) return in_file(path, info.error());
  const std::string image = std::filesystem::path(path).parent_path() / info->image;
  const auto picture = tims::os::read_file(image, kImageBytesMax);
  if (!picture) return picture.error();
  const auto cells = read_map_picture(*picture);
  if (!cells) return in_file(image, cells.error());
  return LoadedMap{.map = localisation::grid_of(*info, *cells)};
}

}  // namespace rack::navigation
