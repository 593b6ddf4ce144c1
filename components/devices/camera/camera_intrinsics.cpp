#include "components/devices/camera/camera_intrinsics.h"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace rack::device {

tims::Result<CameraParamData> rectified_intrinsics(const pictures::CameraCalibration& calibration,
                                                   std::int32_t width, std::int32_t height) {
  const auto fitting = pictures::calibration_for(calibration, width, height);
  if (!fitting) return fitting.error();
  CameraParamData data;
  data.calibration_width = width;
  data.calibration_height = height;
  data.fx = static_cast<float>(fitting->rectified.fx);
  data.fy = static_cast<float>(fitting->rectified.fy);
  data.e0 = static_cast<float>(fitting->rectified.cx);
  data.n0 = static_cast<float>(fitting->rectified.cy);
  data.coordinateRotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  return data;
}

tims::Result<void> check_intrinsics(const CameraParamData& given,
                                    const CameraParamData& rectified) {
  constexpr double kDifferenceMax = 0.01;  // part of the focal length or of a side
  const auto check = [&](const char* name, double set, double known,
                         double whole) -> tims::Result<void> {
    if (set == 0 || std::abs(set - known) <= kDifferenceMax * whole) return {};
    return tims::Error(
        tims::Errc::kInvalidArgument,
        fmt::format("{}={:g} contradicts the calibration, in which it is {:.1f} for pictures of "
                    "{}x{}: set it to 0, or calibration to an empty text",
                    name, set, known, rectified.calibration_width.raw(),
                    rectified.calibration_height.raw()));
  };
  auto good = check("fx", given.fx.raw(), rectified.fx.raw(), rectified.fx.raw());
  if (good) good = check("fy", given.fy.raw(), rectified.fy.raw(), rectified.fy.raw());
  if (good)
    good = check("e0", given.e0.raw(), rectified.e0.raw(), rectified.calibration_width.raw());
  if (good)
    good = check("n0", given.n0.raw(), rectified.n0.raw(), rectified.calibration_height.raw());
  return good;
}

}  // namespace rack::device
