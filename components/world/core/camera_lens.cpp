#include "components/world/core/camera_lens.h"

#include <cmath>

namespace rack::world {

// The distance from the axis where a direction appears must grow with its angle, at least until
// the corners of the picture are reached.
bool is_possible(const CameraDescription& camera) {
  constexpr double kLensStep = 0.001;
  const double corner = std::hypot(camera.width, camera.height) / 2 / camera.focal;
  double last = 0;
  for (double r = kLensStep; r <= kSteepest; r += kLensStep) {
    const double square = r * r;
    const double appears = r * (1 + camera.k1 * square + camera.k2 * square * square);
    if (!(appears > last)) return false;
    if (appears >= corner) return true;
    last = appears;
  }
  return false;
}

}  // namespace rack::world
