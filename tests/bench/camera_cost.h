// What a camera costs: its program, and a listener, pictures of 640 x 480 as motion JPEG that are
// passed on as they are, 30 a second; beside a program that only reads the same files.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// Of CameraV4l alone: its process in plan.count pictures.
bool measure_camera(const Plan& plan);
bool measure_bare_pictures(const Plan& plan);

}  // namespace tims::bench
