// The description of a map in the format of ROS's map_server: the file of its image, resolution and
// origin, as YAML. Pure; yaml-cpp reads and writes it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "components/localisation/grid_map.h"
#include "tims/result.h"

namespace rack::localisation {

struct RosMapInfo {
  std::string image{};    // file name, relative to that of the YAML file
  double resolution = 0;  // m
  double origin_x = 0;    // m: the lower left corner of the image
  double origin_y = 0;    // m
  bool negate = false;
  bool is_raw = false;  // values are per cent instead of grey values
  double occupied_thresh = 0.65;
  double free_thresh = 0.196;
  std::vector<std::string> remarks{};  // "line 3: ..."
};

inline constexpr std::size_t kRosYamlMax = 64 << 10;  // bytes; a description has some hundred

// Error kMalformed: "line 3: ...". As in map_server, unknown keys are ignored, of a key that is
// there twice the first value is used, and thresholds may be in any order; the latter two are
// remarks.
tims::Result<RosMapInfo> read_ros_yaml(std::string_view text);

// The reverse, for an image with this file name.
std::string to_ros_yaml(const GridMap& map, std::string_view image);

}  // namespace rack::localisation
