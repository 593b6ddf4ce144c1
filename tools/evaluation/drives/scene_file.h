// Reads a scene from its files.
#pragma once

#include <string>

#include "tims/result.h"
#include "tools/evaluation/drives/drive.h"

namespace rack::drives {

// `plan`: a floor plan (DXF, in m unless it states its unit) or a map of ROS (.yaml). Errors name
// the file.
tims::Result<Scene> read_scene(const std::string& world, const std::string& plan);

}  // namespace rack::drives
