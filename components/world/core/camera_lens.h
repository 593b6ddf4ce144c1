// What the lens of a camera may be.
#pragma once

#include "components/world/core/description.h"

namespace rack::world {

// Whether every pixel of the picture sees exactly one direction, not farther than kSteepest from
// the axis: a lens with other coefficients would show a place twice, or a picture of no end.
bool is_possible(const CameraDescription& camera);

inline constexpr double kSteepest = 3;  // tangent of the angle; 72 degrees

}  // namespace rack::world
