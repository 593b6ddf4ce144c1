// Pictures with markers, drawn for tests: what a camera sees of markers in front of it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "components/vision/camera_geometry.h"
#include "components/vision/marker_finder.h"
#include "components/vision/marker_map.h"

namespace rack::vision {

struct Rendered {
  int width = 640;
  int height = 480;
  std::vector<std::uint8_t> pixels{};

  [[nodiscard]] GreyView view() const { return {width, height, pixels}; }
};

// The markers of a map, seen by a robot at `pose`; with noise (standard deviation, grey values) and
// blur (pixels). Later markers cover earlier ones.
Rendered rendered(std::span<const Marker> markers, const Pose& pose, const CameraGeometry& camera,
                  double noise, double blur);

// 640 x 480, 60 degrees wide, 500 mm above the ground.
CameraGeometry test_camera(const Pose& mounting = {.z = -500});

}  // namespace rack::vision
