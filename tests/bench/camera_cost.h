// The CPU time of CameraV4l with a listener: pictures of 640 x 480 as motion JPEG, forwarded
// unchanged, 30 per second; compared with a program that only reads the same files.
#pragma once

#include "tests/bench/plan.h"

namespace tims::bench {

// Whether this build has components with pictures.
bool has_pictures();

// CPU time of the process CameraV4l for plan.count pictures.
bool measure_camera(const Plan& plan);
bool measure_bare_pictures(const Plan& plan);

}  // namespace tims::bench
