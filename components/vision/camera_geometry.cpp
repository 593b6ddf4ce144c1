#include "components/vision/camera_geometry.h"

#include <cmath>

namespace rack::vision {

using scan3d::Frame;
using scan3d::Place;

tims::Result<CameraGeometry> CameraGeometry::make(const CameraParamData& parameters, int width,
                                                  int height, const Pose& mounting) {
  const auto is_size = [](double value) { return std::isfinite(value) && value > 0; };
  const double calibrated_width = parameters.calibration_width.raw();
  const double calibrated_height = parameters.calibration_height.raw();
  if (!is_size(parameters.fx.raw()) || !is_size(parameters.fy.raw()) || calibrated_width <= 0 ||
      calibrated_height <= 0)
    return tims::Error(tims::Errc::kInvalidArgument,
                       "the camera has no focal length: set its parameter calibration, or fx, fy, "
                       "e0 and n0 (camera-calibrate measures them)");
  const double across = width / calibrated_width;
  const double down = height / calibrated_height;
  const auto centre = [&](double given, double size) { return is_size(given) ? given : size / 2; };
  const Lens lens{.fx = parameters.fx.raw() * across,
                  .fy = parameters.fy.raw() * down,
                  .cx = centre(parameters.e0.raw() * across, width),
                  .cy = centre(parameters.n0.raw() * down, height)};
  return CameraGeometry(lens, Frame(mounting));
}

std::optional<ImagePoint> CameraGeometry::pixel(const Place& place) const {
  constexpr double kNearest = 1;  // mm in front of the lens
  const Place seen = to_camera_ * place;
  if (!(seen.x > kNearest)) return std::nullopt;
  return ImagePoint{lens_.cx + lens_.fx * seen.y / seen.x, lens_.cy + lens_.fy * seen.z / seen.x};
}

std::optional<Place> CameraGeometry::ground(const ImagePoint& pixel) const {
  const Place lens = mount_ * Place{};
  const Place ahead =
      mount_ * Place{1, (pixel.column - lens_.cx) / lens_.fx, (pixel.row - lens_.cy) / lens_.fy};
  const Place ray = ahead + lens * -1;
  if (!(ray.z > 1e-6) || lens.z >= 0) return std::nullopt;
  return lens + ray * (-lens.z / ray.z);
}

}  // namespace rack::vision
