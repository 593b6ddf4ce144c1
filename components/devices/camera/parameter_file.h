// Parameter files of the original's CameraDcam: a name and a number per line, for example "fx
// 812.5".
//
// Names: f fx fy sx sy dx dy k1 k2 p1 p2 e0 n0 calibration_width calibration_height (intrinsic),
// r1 to r9 (rotation, by rows) and t1 to t3 (translation). Other lines are ignored, as there.
#pragma once

#include <string_view>

#include "rack/proxies/camera.h"
#include "tims/result.h"

namespace rack::device {

inline constexpr std::size_t kParameterFileMax = std::size_t{64} * 1024;  // bytes

// Changes what the text contains. kMalformed: a name without a number, with its line.
tims::Result<void> add_parameters(std::string_view text, CameraParamData& parameters);

}  // namespace rack::device
