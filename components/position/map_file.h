// Loads maps from files on this host: floor plans (DXF) and maps of ROS, by the one reader
// (components/localisation/floor_plan.h).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "components/geometry/dxf.h"
#include "components/localisation/floor_plan.h"
#include "components/localisation/grid_map.h"
#include "tims/result.h"

namespace rack::navigation {

struct LoadedMap {
  localisation::GridMap map{};
  std::vector<std::string> remarks{};  // what of the file is not in the map, with its place
};

inline constexpr double kUsualResolution = 50;  // mm

// Errors and remarks name the file: "floor.dxf, line 7: ...".
tims::Result<localisation::FloorPlan> load_plan(const std::string& path,
                                                const PlanPlacement& placement);
// As cells; those of a drawing have `resolution` mm.
tims::Result<LoadedMap> load_map(const std::string& path, const PlanPlacement& placement,
                                 double resolution = kUsualResolution);
// As lines, with the remarks of the drawing.
tims::Result<DxfPlan> load_lines(const std::string& path, const PlanPlacement& placement);

}  // namespace rack::navigation
