// Loads maps from files: a floor plan in DXF, or a map of ROS (.yaml, with its image in the same
// folder).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "components/localisation/grid_map.h"
#include "tims/result.h"

namespace rack::navigation {

inline constexpr std::size_t kPlanBytesMax = 64 << 20;  // a floor plan in DXF

// Conversion of a floor plan: x = (plan y - offset_x) * scale, y = (plan x - offset_y) * scale.
struct PlanPlacement {
  double scale = 1000;  // mm per unit of the plan; 0: as the plan states
  double offset_x = 0;
  double offset_y = 0;
  double resolution = 50;  // mm
};

struct LoadedMap {
  localisation::GridMap map{};
  std::vector<std::string> remarks{};  // what of the file is not in the map, with its place
};

// Errors and remarks name the file: "floor.dxf, line 7: ...".
tims::Result<LoadedMap> load_map(const std::string& path, const PlanPlacement& placement);

}  // namespace rack::navigation
