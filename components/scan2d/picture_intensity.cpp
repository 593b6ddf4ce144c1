#include "components/scan2d/picture_intensity.h"

#include <cmath>
#include <string>

namespace rack::scan2d {
namespace {

using scan3d::Frame;
using scan3d::Place;

tims::Error wrong(std::string text) {
  return {tims::Errc::kInvalidArgument, "the camera's image: " + std::move(text)};
}

// 0: the pixel format is not supported.
std::size_t bytes_of_pixel(u16 mode) {
  switch (mode) {
    case camera_mode::kMono8:
    case camera_mode::kIntensity:
    case camera_mode::kRaw8:
      return 1;
    case camera_mode::kMono12:
    case camera_mode::kMono16:
    case camera_mode::kYuv422:
      return 2;
    case camera_mode::kRgb24:
      return 3;
    default:
      return 0;
  }
}

i16 brightness(const CameraData& picture, std::size_t at) {
  const auto byte = [&](std::size_t i) { return std::to_integer<int>(picture.image[at + i]); };
  switch (picture.mode) {
    case camera_mode::kMono12:
    case camera_mode::kMono16:
      return static_cast<i16>(byte(0) << 8 | byte(1));
    case camera_mode::kYuv422:
      return static_cast<i16>(byte(1));
    case camera_mode::kRgb24:  // perceived brightness
      return static_cast<i16>((77 * byte(0) + 150 * byte(1) + 29 * byte(2)) / 256);
    default:
      return static_cast<i16>(byte(0));
  }
}

}  // namespace

tims::Result<CameraView> CameraView::make(const CameraParamData& camera, const Pose& mounting) {
  const auto is_size = [](double value) { return std::isfinite(value) && value > 0; };
  if (!is_size(camera.fx.raw()) || !is_size(camera.fy.raw()) || camera.calibration_width <= 0 ||
      camera.calibration_height <= 0)
    return tims::Error(tims::Errc::kInvalidArgument,
                       "the camera has no focal length: set its parameters fx and fy (pixels)");
  return CameraView(camera, mounting);
}

std::optional<Pixel> CameraView::pixel(const Place& place, double width, double height) const {
  const Place seen = to_camera_ * place;
  constexpr double kNearest = 1;  // mm in front of the lens
  if (!(seen.x > kNearest)) return {};
  const double f = camera_.f > 0 ? static_cast<double>(camera_.f.raw()) : 1;
  double x = f * seen.y / seen.x;  // mm on the sensor
  double y = f * seen.z / seen.x;
  if (camera_.f > 0) {
    const double k1 = static_cast<double>(camera_.k1.raw());
    const double k2 = static_cast<double>(camera_.k2.raw());
    const double p1 = static_cast<double>(camera_.p1.raw());
    const double p2 = static_cast<double>(camera_.p2.raw());
    const double r2 = x * x + y * y;
    const double radial = 1 + k1 * r2 + k2 * r2 * r2;
    const double bent_x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
    y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
    x = bent_x;
  }
  const double column =
      (x / f * static_cast<double>(camera_.fx.raw()) + static_cast<double>(camera_.e0.raw())) *
      width / camera_.calibration_width.raw();
  const double row =
      (y / f * static_cast<double>(camera_.fy.raw()) + static_cast<double>(camera_.n0.raw())) *
      height / camera_.calibration_height.raw();
  const bool is_inside = column >= 0 && column < width && row >= 0 && row < height;  // no NaN
  if (!is_inside) return {};
  return Pixel{static_cast<std::size_t>(column), static_cast<std::size_t>(row)};
}

tims::Result<void> add_brightness(const CameraView& view, const CameraData& picture,
                                  const Pose& moved, Scan2dData& scan) {
  const std::size_t bytes = bytes_of_pixel(picture.mode);
  if (bytes == 0)
    return wrong("mode " + std::to_string(picture.mode) +
                 " is not supported; use grey, yuv422 or rgb24");
  const std::size_t width = picture.width;
  const std::size_t height = picture.height;
  if (picture.image.size() < width * height * bytes)
    return wrong("it has fewer bytes than its size requires");
  const Frame to_picture(moved);
  for (ScanPoint& point : scan.points) {
    const Place place{static_cast<double>(point.x.raw()), static_cast<double>(point.y.raw()), 0};
    const auto pixel =
        view.pixel(to_picture * place, static_cast<double>(width), static_cast<double>(height));
    point.intensity =
        pixel ? brightness(picture, (pixel->row * width + pixel->column) * bytes) : i16{0};
  }
  return {};
}

}  // namespace rack::scan2d
