// The file of a world: TOML, in mm, degrees and durations such as "60ms". README.md describes its
// keys.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/toml.h"
#include "components/localisation/floor_plan.h"
#include "components/world/core/description.h"
#include "tims/result.h"

namespace rack::world {

struct WorldFile {
  WorldDescription description{};  // valid only when there are no problems
  std::vector<tims::base::Problem> problems{};
  // What of drawings is not in the world: "floor.dxf, line 17: LINE without an end".
  std::vector<std::string> remarks{};
  std::vector<tims::base::Problem> hints{};  // keys by their former names
};

inline constexpr std::size_t kRobotsMax = 16;
inline constexpr std::size_t kSensorsMax = 16;  // per robot
inline constexpr std::size_t kPeopleMax = 200;
inline constexpr std::size_t kWalksMax = 20;       // walks among the people
inline constexpr std::size_t kWalkPlacesMax = 10;  // per walk
inline constexpr std::size_t kObstaclesMax = 5000;
inline constexpr int kPictureMin = 16;  // pixels, of each side of a camera's picture
inline constexpr int kPictureMax = 1920;

// Reads a floor plan, the picture of a map of ROS, or a map of markers by its name in the world's
// file.
using ReadPlan = std::function<tims::Result<std::string>(const std::string& name)>;
using DecodePicture = decltype(localisation::MapSources::decode);

// Reports every problem with file, line and column.
WorldFile read_world(const tims::base::TextFile& file, const ReadPlan& read_plan,
                     const DecodePicture& decode);

}  // namespace rack::world
