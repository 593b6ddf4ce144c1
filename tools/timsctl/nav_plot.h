// Pictures for `timsctl nav`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/plot/picture.h"
#include "tools/timsctl/nav_robot.h"

namespace timsctl {

// Writes .svg, or .png by OpenCV, which is loaded then. Throws Failure.
void write_picture(const std::string& file, const rack::plot::Picture& picture);

struct RobotPicture {
  rack::plot::Picture picture{};  // the map, the pose of the robot, the samples of its localisation
  // If there is no map: why those that the robot names are not available here; empty: it names
  // none.
  std::vector<std::string> missing_maps{};
};
// The map is that of a file if it is on this host, else that of its GridMap or FeatureMap.
RobotPicture picture_of(NavRobot& robot);

}  // namespace timsctl
