// What a camera sees at one time beside the static objects of the description: a copy, so that the
// picture can be rendered in another thread while the world goes on.
#pragma once

#include <array>
#include <vector>

#include "components/world/core/people.h"
#include "components/world/core/shapes.h"
#include "components/world/core/world.h"

namespace rack::world {

struct SeenRobot {
  std::size_t id = 0;
  Box hull{};
};

struct View {
  tims::Duration age{};          // of the world
  std::array<double, 3> from{};  // north, east, down
  // From the frame of the camera (x forward, y right, z down) to that of the world.
  std::array<std::array<double, 3>, 3> turn{};
  std::vector<SeenRobot> robots{};  // all others
  std::vector<Figure> people{};
  std::vector<ObstacleDescription> obstacles{};  // those placed by commands
};

}  // namespace rack::world
