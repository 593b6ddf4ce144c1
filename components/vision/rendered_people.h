// Pictures with people and furniture, drawn for tests: what a camera sees of them.
#pragma once

#include <cstdint>
#include <span>

#include "components/vision/camera_geometry.h"
#include "components/vision/rendered_markers.h"

namespace rack::vision {

// Somebody who stands on the ground, in the robot's frame, and faces the camera.
struct DrawnPerson {
  double x = 0;  // mm
  double y = 0;
  double height = 1750;
  double step = 0;         // mm between the feet, beside a narrow stance
  bool is_bright = false;  // clothes
};

// A room with a floor, a wall and its texture, at 7 m.
Rendered rendered_room(const CameraGeometry& camera, unsigned seed);
// Boxes, shelves, a table, a lamp, a door.
void add_furniture(Rendered& picture, const CameraGeometry& camera);
void add_person(Rendered& picture, const DrawnPerson& person, const CameraGeometry& camera);
// Noise (standard deviation, grey values) and blur (pixels) of a camera.
void add_noise(Rendered& picture, double noise, double blur, unsigned seed);

}  // namespace rack::vision
