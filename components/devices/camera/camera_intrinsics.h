// The geometry of rectified pictures, as the camera class reports it (GET_PARAMETER). Pure.
#pragma once

#include "components/pictures/camera_calibration.h"
#include "rack/proxies/camera.h"
#include "tims/result.h"

namespace rack::device {

// Of rectified pictures of this size, which have no distortion. kInvalidArgument: the calibration
// is for another aspect ratio.
tims::Result<CameraParamData> rectified_intrinsics(const pictures::CameraCalibration& calibration,
                                                   std::int32_t width, std::int32_t height);

// Whether values that were set beside the calibration (fx, fy, e0, n0; 0: not set) are those of the
// rectified pictures, within 1 %. The error names the one that is not.
tims::Result<void> check_intrinsics(const CameraParamData& given, const CameraParamData& rectified);

}  // namespace rack::device
