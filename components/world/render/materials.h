// The surfaces of a simulated world, painted by a procedure: walls, floors, crates.
#pragma once

#include <array>
#include <cstddef>

#include "components/world/render/texture.h"

namespace rack::world {

struct Materials {
  explicit Materials(bool is_indoors);

  static constexpr double kWallPixel = 10;    // mm of a pixel
  static constexpr double kGroundPixel = 20;  // also of the ceiling
  static constexpr int kSide = 256;           // pixels of walls, ground and ceiling
  static constexpr int kCrateSide = 64;       // pixels of a side of a crate, of any size

  // Of walls: v is 0 at the ground and grows upwards.
  std::array<Texture, 3> walls;
  Texture ground;
  Texture ceiling;
  Texture crate;
  Texture barrel;
  Texture robot;
  Texture wheel;
  Texture sky;
};

}  // namespace rack::world
