// Pictures for `timsctl nav`: what there is to draw, and into which file.
#pragma once

#include <optional>
#include <string>

#include "tools/plot/picture.h"
#include "tools/timsctl/nav_robot.h"

namespace timsctl {

// As .svg, or by rsvg-convert as .png. Throws Failure.
void write_picture(const std::string& file, const rack::plot::Picture& picture);

// The map that a robot uses: from the file it has it from, when that is here, else as its GridMap
// or FeatureMap sends it. Nothing: it has none, or it cannot be seen from here.
std::optional<rack::localisation::GridMap> map_of(NavRobot& robot);

// The map, where the robot is and the samples of its localisation.
rack::plot::Picture picture_of(NavRobot& robot);

}  // namespace timsctl
