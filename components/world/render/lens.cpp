#include "components/world/render/lens.h"

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace rack::world {

namespace {

std::size_t pixels_of(const CameraDescription& camera) {
  return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
}

// The directions, as x/z and y/z, in which the pixels of the camera look.
cv::Mat directions_of(const CameraDescription& camera) {
  cv::Mat points(camera.height * camera.width, 1, CV_64FC2);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x)
      points.at<cv::Vec2d>(y * camera.width + x) = {static_cast<double>(x), static_cast<double>(y)};
  const cv::Matx33d matrix(camera.focal, 0, (camera.width - 1) / 2.0, 0, camera.focal,
                           (camera.height - 1) / 2.0, 0, 0, 1);
  const cv::Vec4d distortion(camera.k1, camera.k2, 0, 0);
  cv::Mat directions;
  constexpr int kIterations = 60;
  constexpr double kExact = 1e-9;
  cv::undistortPoints(
      points, directions, matrix, distortion, cv::noArray(), cv::noArray(),
      cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, kIterations, kExact));
  return directions;
}

}  // namespace

Lens::Lens(const CameraDescription& camera)
    : camera_(camera),
      width_(camera.width),
      height_(camera.height),
      cx_((camera.width - 1) / 2.0),
      cy_((camera.height - 1) / 2.0),
      is_straight_(camera.k1 == 0 && camera.k2 == 0) {
  if (is_straight_) return;
  const cv::Mat directions = directions_of(camera);
  double x_max = 0;
  double y_max = 0;
  for (int i = 0; i < directions.rows; ++i) {
    const auto& direction = directions.at<cv::Vec2d>(i);
    x_max = std::max(x_max, std::abs(direction[0]));
    y_max = std::max(y_max, std::abs(direction[1]));
  }
  // Whole pixels on each side of the middle one, and one for the interpolation.
  cx_ = std::ceil(x_max * camera.focal) + 1;
  cy_ = std::ceil(y_max * camera.focal) + 1;
  width_ = static_cast<int>(cx_) * 2 + 1;
  height_ = static_cast<int>(cy_) * 2 + 1;
  cv::Mat map(camera.height, camera.width, CV_32FC2);
  for (int i = 0; i < directions.rows; ++i) {
    const auto& direction = directions.at<cv::Vec2d>(i);
    map.at<cv::Vec2f>(i / camera.width, i % camera.width) = {
        static_cast<float>(direction[0] * camera.focal + cx_),
        static_cast<float>(direction[1] * camera.focal + cy_)};
  }
  places_.resize(2 * pixels_of(camera));
  parts_.resize(pixels_of(camera));
  bent_.resize(pixels_of(camera));
  cv::Mat places(camera.height, camera.width, CV_16SC2, places_.data());
  cv::Mat parts(camera.height, camera.width, CV_16UC1, parts_.data());
  cv::convertMaps(map, cv::noArray(), places, parts, CV_16SC2);
}

void Lens::apply(std::span<std::uint32_t> pinhole, std::span<std::uint8_t> bgr) {
  const cv::Mat straight(height_, width_, CV_8UC4, pinhole.data());
  cv::Mat picture(camera_.height, camera_.width, CV_8UC3, bgr.data());
  if (is_straight_) return cv::cvtColor(straight, picture, cv::COLOR_BGRA2BGR);
  cv::Mat bent(camera_.height, camera_.width, CV_8UC4, bent_.data());
  const cv::Mat places(camera_.height, camera_.width, CV_16SC2, places_.data());
  const cv::Mat parts(camera_.height, camera_.width, CV_16UC1, parts_.data());
  cv::remap(straight, bent, places, parts, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::cvtColor(bent, picture, cv::COLOR_BGRA2BGR);
}

}  // namespace rack::world
