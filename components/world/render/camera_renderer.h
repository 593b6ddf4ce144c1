// Renders what a camera of a simulated robot sees: walls, the ground, obstacles, people, other
// robots, and markers on the walls, with the distortion of the lens and the noise of the pixels.
// The same view gives the same picture. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "components/world/core/view.h"
#include "tims/result.h"

namespace rack::world {

class CameraRenderer {
 public:
  // Of a sensor of the kind camera. The description is copied.
  static tims::Result<std::unique_ptr<CameraRenderer>> make(const WorldDescription& world,
                                                            const SensorId& sensor);
  ~CameraRenderer();

  [[nodiscard]] const CameraDescription& camera() const;
  // width x height x 3 bytes, blue first; valid until the next call.
  tims::Result<std::span<const std::byte>> render(const View& view);

 private:
  class Studio;
  explicit CameraRenderer(std::unique_ptr<Studio> studio);

  std::unique_ptr<Studio> studio_;
};

}  // namespace rack::world
