// A world's file: TOML, in mm, degrees and durations as "60ms". What its keys are says README.md.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/toml.h"
#include "components/world/core/description.h"
#include "tims/result.h"

namespace rack::world {

struct WorldFile {
  WorldDescription description{};  // to be used only when there are no problems
  std::vector<tims::base::Problem> problems{};
  // Of drawings: what could not be read, "floor.dxf, line 17: LINE without an end".
  std::vector<std::string> passed_over{};
};

inline constexpr std::size_t kRobotsMax = 16;
inline constexpr std::size_t kSensorsMax = 16;  // of a robot
inline constexpr std::size_t kPeopleMax = 200;
inline constexpr std::size_t kWalksMax = 20;       // of them
inline constexpr std::size_t kWalkPlacesMax = 10;  // of a walk
inline constexpr std::size_t kObstaclesMax = 5000;

// The text of a floor plan, by its name as the world's file has it.
using ReadPlan = std::function<tims::Result<std::string>(const std::string& name)>;

// Every problem with file, line and column.
WorldFile read_world(const tims::base::TextFile& file, const ReadPlan& read_plan);

}  // namespace rack::world
