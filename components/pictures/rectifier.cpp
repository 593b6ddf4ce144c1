#include "components/pictures/rectifier.h"

#include <algorithm>
#include <utility>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::pictures {
namespace {

cv::Matx33d matrix_of(const CameraMatrix& camera) {
  return {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1};
}

}  // namespace

struct Rectifier::Places {
  cv::Size size;
  cv::Mat whole;  // pixel of the camera's picture, for each pixel
  cv::Mat part;   // and its fraction
};

Rectifier::Rectifier(std::unique_ptr<Places> places) : places_(std::move(places)) {}
Rectifier::Rectifier(Rectifier&&) noexcept = default;
Rectifier& Rectifier::operator=(Rectifier&&) noexcept = default;
Rectifier::~Rectifier() = default;

tims::Result<Rectifier> Rectifier::make(const CameraCalibration& calibration) {
  if (calibration.width < 1 || calibration.height < 1 || calibration.width > kCalibrationSideMax ||
      calibration.height > kCalibrationSideMax ||
      std::int64_t{calibration.width} * calibration.height > kRectifiedPixelsMax)
    return tims::Error(tims::Errc::kTooBig, "the picture has too many pixels to be rectified");
  auto places = std::make_unique<Places>();
  places->size = {calibration.width, calibration.height};
  const cv::Mat rotation(3, 3, CV_64F, const_cast<double*>(calibration.rotation.data()));
  auto done = call_opencv("preparing the rectification", [&] {
    cv::initUndistortRectifyMap(matrix_of(calibration.camera), calibration.distortion, rotation,
                                matrix_of(calibration.rectified), places->size, CV_16SC2,
                                places->whole, places->part);
  });
  if (!done) return done.error();
  return Rectifier(std::move(places));
}

tims::Result<void> Rectifier::rectify(const Raster& from, std::span<std::byte> to) const {
  const auto width = static_cast<std::size_t>(places_->size.width);
  const auto height = static_cast<std::size_t>(places_->size.height);
  if (from.channels < 1 || from.channels > 4 || from.channel_bytes < 1 || from.channel_bytes > 2)
    return tims::Error(tims::Errc::kInvalidArgument, "pixels of this kind cannot be rectified");
  const std::size_t line = width * static_cast<std::size_t>(from.channels) *
                           static_cast<std::size_t>(from.channel_bytes);
  const std::size_t stride = std::max(from.line_bytes, line);
  if (from.bytes.size() < std::uint64_t{stride} * (height - 1) + line ||
      to.size() < std::uint64_t{line} * height)
    return tims::Error(tims::Errc::kMalformed,
                       "the picture has fewer bytes than its size requires");
  const int type = CV_MAKETYPE(from.channel_bytes == 1 ? CV_8U : CV_16U, from.channels);
  const cv::Mat source(places_->size, type, const_cast<std::byte*>(from.bytes.data()), stride);
  cv::Mat target(places_->size, type, to.data());
  return call_opencv("rectifying a picture", [&] {
    cv::remap(source, target, places_->whole, places_->part, cv::INTER_LINEAR, cv::BORDER_CONSTANT,
              cv::Scalar::all(from.border));
    CV_Assert(target.data == reinterpret_cast<uchar*>(to.data()));
  });
}

}  // namespace rack::pictures
