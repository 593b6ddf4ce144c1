// Maps out of files: a floor plan in DXF, or a map of ROS (.yaml, with its picture beside it).
#pragma once

#include <string>
#include <string_view>

#include "components/localisation/grid_map.h"
#include "tims/result.h"

namespace rack::navigation {

// How a floor plan becomes a map: x = (its y - offset_x) * scale, y = (its x - offset_y) * scale.
struct PlanPlacement {
  double scale = 1000;  // mm for each of its units
  double offset_x = 0;
  double offset_y = 0;
  double resolution = 50;  // mm
};

// Errors name the file: "floor.dxf: line 7: ...".
tims::Result<localisation::GridMap> load_map(const std::string& path,
                                             const PlanPlacement& placement);

// All of it; directories and files of more than 512 MB are refused.
tims::Result<std::string> read_file(const std::string& path);

// Beside the old one first: who reads it sees one of the two.
tims::Result<void> write_file(const std::string& path, std::string_view text);

}  // namespace rack::navigation
