#include "components/scan2d/picture_intensity.h"

#include <cmath>
#include <string>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::scan2d {
namespace {

using scan3d::Frame;
using scan3d::Place;
using tims::Result;

constexpr double kNearest = 1;  // mm in front of the lens

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

i16 brightness(u16 mode, const std::byte* pixel) {
  const auto byte = [&](std::size_t i) { return std::to_integer<int>(pixel[i]); };
  if (mode == camera_mode::kMono12 || mode == camera_mode::kMono16)
    return static_cast<i16>(byte(0) << 8 | byte(1));
  return static_cast<i16>(byte(mode == camera_mode::kYuv422 ? 1 : 0));
}

// OpenCV's header of our memory.
template <typename Value>
cv::Mat column_of(std::vector<Value>& values, int type) {
  return {static_cast<int>(values.size()), 1, type, values.data()};
}

}  // namespace

Result<CameraView> CameraView::make(const CameraParamData& camera, const Pose& mounting) {
  const auto is_size = [](double value) { return std::isfinite(value) && value > 0; };
  if (!is_size(camera.fx.raw()) || !is_size(camera.fy.raw()) || camera.calibration_width <= 0 ||
      camera.calibration_height <= 0)
    return tims::Error(tims::Errc::kInvalidArgument,
                       "the camera has no focal length: set its parameters fx and fy (pixels)");
  pictures::use_one_thread();
  return CameraView(camera, mounting);
}

// OpenCV's distances are in focal lengths, those of the distortion in mm. Its x is to the right,
// its y down, its z forward.
void CameraView::project(double width, double height) {
  const double across = width / camera_.calibration_width.raw();
  const double down = height / camera_.calibration_height.raw();
  const cv::Matx33d lens(static_cast<double>(camera_.fx.raw()) * across, 0,
                         static_cast<double>(camera_.e0.raw()) * across, 0,
                         static_cast<double>(camera_.fy.raw()) * down,
                         static_cast<double>(camera_.n0.raw()) * down, 0, 0, 1);
  const double f = camera_.f > 0 ? static_cast<double>(camera_.f.raw()) : 0;
  const cv::Vec4d distortion(static_cast<double>(camera_.k1.raw()) * f * f,
                             static_cast<double>(camera_.k2.raw()) * f * f * f * f,
                             static_cast<double>(camera_.p1.raw()) * f,
                             static_cast<double>(camera_.p2.raw()) * f);
  cv::Mat projected = column_of(projected_, CV_64FC2);
  cv::projectPoints(column_of(seen_, CV_64FC3), cv::Vec3d(), cv::Vec3d(), lens,
                    f > 0 ? cv::Mat(distortion) : cv::Mat(), projected);
}

Result<std::span<const std::optional<Pixel>>> CameraView::pixels(std::span<const Place> places,
                                                                 double width, double height) {
  seen_.clear();
  for (const Place& place : places) {
    const Place seen = to_camera_ * place;
    seen_.push_back({seen.y, seen.z, seen.x});
  }
  pixels_.assign(places.size(), std::nullopt);
  projected_.resize(places.size());
  using Pixels = std::span<const std::optional<Pixel>>;
  if (places.empty()) return Pixels(pixels_);
  if (auto done = pictures::call_opencv("projecting points", [&] { project(width, height); });
      !done)
    return done.error();
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const auto [column, row] = projected_[i];
    const bool is_inside = seen_[i][2] > kNearest && column >= 0 && column < width && row >= 0 &&
                           row < height;  // no NaN
    if (is_inside)
      pixels_[i] = Pixel{static_cast<std::size_t>(column), static_cast<std::size_t>(row)};
  }
  return Pixels(pixels_);
}

Result<void> CameraView::add_brightness(const CameraData& picture, const Pose& moved,
                                        Scan2dData& scan) {
  const std::size_t bytes = bytes_of_pixel(picture.mode);
  if (bytes == 0)
    return wrong("mode " + std::to_string(picture.mode) +
                 " is not supported; use grey, yuv422 or rgb24");
  const std::size_t width = picture.width;
  const std::size_t height = picture.height;
  if (picture.image.size() < width * height * bytes)
    return wrong("it has fewer bytes than its size requires");
  const Frame to_picture(moved);
  places_.clear();
  for (const ScanPoint& point : scan.points)
    places_.push_back(to_picture * Place{static_cast<double>(point.x.raw()),
                                         static_cast<double>(point.y.raw()), 0});
  const auto found = pixels(places_, static_cast<double>(width), static_cast<double>(height));
  if (!found) return found.error();
  // Only the pixels of the points are converted, instead of the whole image.
  const bool is_colour = picture.mode == camera_mode::kRgb24;
  colours_.assign(bytes * found->size(), std::byte{0});
  for (std::size_t i = 0; i < found->size(); ++i)
    if (const auto& pixel = (*found)[i])
      std::copy_n(&picture.image[(pixel->row * width + pixel->column) * bytes], bytes,
                  &colours_[i * bytes]);
  greys_.resize(found->size());
  if (is_colour && !greys_.empty()) {
    auto done = pictures::call_opencv("brightness of points", [&] {
      cv::Mat colours(static_cast<int>(greys_.size()), 1, CV_8UC3, colours_.data());
      cv::Mat greys = column_of(greys_, CV_8U);
      cv::cvtColor(colours, greys, cv::COLOR_BGR2GRAY);
    });
    if (!done) return done;
  }
  for (std::size_t i = 0; i < found->size(); ++i)
    scan.points[i].intensity = is_colour ? brightness(camera_mode::kMono8, &greys_[i])
                                         : brightness(picture.mode, &colours_[i * bytes]);
  return {};
}

}  // namespace rack::scan2d
