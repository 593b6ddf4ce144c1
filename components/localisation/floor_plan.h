// The one reader for maps of floors from files: floor plans (DXF), and maps of ROS (.yaml with its
// picture). What is read can be used as lines and as cells, whatever the file contains. Pure: the
// caller opens files and decodes pictures (components/position/map_file.h does).
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "components/geometry/dxf.h"
#include "components/localisation/grid_map.h"
#include "components/pictures/grey_picture.h"
#include "tims/result.h"

namespace rack::localisation {

// Of any file of a map: more than the largest picture without compression.
inline constexpr std::size_t kMapBytesMax = std::size_t{256} << 20;

struct MapSources {
  // Errors name the file.
  std::function<tims::Result<std::string>(const std::string& path)> read_file{};
  std::function<tims::Result<pictures::GreyPicture>(std::string_view bytes)> decode{};
};

struct FloorPlan {
  std::string path{};
  DxfPlan drawing{};                   // empty for a map of ROS
  std::optional<GridMap> cells{};      // only for a map of ROS
  std::vector<std::string> remarks{};  // what of the file is not used, with its place
};

// By the extension: .yaml and .yml are maps of ROS. These have a resolution and an origin of their
// own, so `placement` is for drawings only. Errors and remarks name the file: "floor.dxf, line 7:
// ...".
tims::Result<FloorPlan> read_floor_plan(const std::string& path, const PlanPlacement& placement,
                                        const MapSources& sources);

// Whether read_floor_plan() takes it for a map of ROS.
bool is_ros_map(std::string_view path);

// The lines of the drawing, or the outlines of the walls of a map of ROS as a drawing in mm. Their
// remarks are those of the file, too.
tims::Result<DxfPlan> lines_of(FloorPlan plan);

// The cells of the map of ROS; the drawing in cells of `resolution` mm.
tims::Result<GridMap> cells_of(FloorPlan plan, double resolution);

}  // namespace rack::localisation
