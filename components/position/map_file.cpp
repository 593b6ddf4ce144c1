#include "components/position/map_file.h"

#include <utility>

#include "components/position/map_picture.h"
#include "os/file.h"

namespace rack::navigation {

tims::Result<localisation::FloorPlan> load_plan(const std::string& path,
                                                const PlanPlacement& placement) {
  return localisation::read_floor_plan(path, placement,
                                       {.read_file =
                                            [](const std::string& file) {
                                              return tims::os::read_file(
                                                  file, localisation::kMapBytesMax);
                                            },
                                        .decode = read_map_picture});
}

tims::Result<LoadedMap> load_map(const std::string& path, const PlanPlacement& placement,
                                 double resolution) {
  auto plan = load_plan(path, placement);
  if (!plan) return plan.error();
  LoadedMap loaded{.remarks = std::exchange(plan->remarks, {})};
  auto map = localisation::cells_of(std::move(*plan), resolution);
  if (!map) return map.error();
  loaded.map = std::move(*map);
  return loaded;
}

tims::Result<DxfPlan> load_lines(const std::string& path, const PlanPlacement& placement) {
  auto plan = load_plan(path, placement);
  if (!plan) return plan.error();
  return localisation::lines_of(std::move(*plan));
}

}  // namespace rack::navigation
