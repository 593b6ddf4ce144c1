// Pictures for `timsctl nav`.
#pragma once

#include <optional>
#include <string>

#include "tools/plot/picture.h"
#include "tools/timsctl/nav_robot.h"

namespace timsctl {

// Writes .svg, or .png by OpenCV, which is loaded then. Throws Failure.
void write_picture(const std::string& file, const rack::plot::Picture& picture);

// The map of a robot: from its file if that is on this host, else from its GridMap or FeatureMap.
// Empty if there is no map or it is not available here.
std::optional<rack::localisation::GridMap> map_of(NavRobot& robot);

// The map, the pose of the robot and the samples of its localisation.
rack::plot::Picture picture_of(NavRobot& robot);

}  // namespace timsctl
