// Loads librack-world-camera (camera_film.h) when the first camera is made; it stays loaded.
#pragma once

#include "components/devices/core/scene.h"
#include "components/world/camera_film.h"

namespace rack::device {

// The pictures of a camera, in the form that emulators take them. The world must outlive them.
// Error kSystem: the library is missing, for example because this was built without OpenCV.
tims::Result<std::shared_ptr<emulator::PictureSource>> pictures_of(const world::World& world,
                                                                   const world::SensorId& sensor);

}  // namespace rack::device
