// A picture of the residuals of a calibration: where points were seen beside the expected position,
// and the error of each view. Drawn by OpenCV. Pure.
//
// A good calibration has short lines in all directions, and no pattern. Lines that point to or from
// the centre: the distortion needs another term (k3), or the edges of the picture were not covered.
#pragma once

#include <cstddef>
#include <string>

#include "tims/result.h"
#include "tools/camera_calibrate/calibrate.h"

namespace rack::camera_calibrate {

// As PNG.
tims::Result<std::string> draw_residuals(const Calibrated& calibrated);

}  // namespace rack::camera_calibrate
