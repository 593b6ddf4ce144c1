#include "components/vision/rendered_markers.h"

#include <array>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "components/vision/marker_picture.h"

namespace rack::vision {

namespace {

constexpr int kCell = 32;  // pixels of a cell before it is drawn into the picture
constexpr int kWall = 120;

void draw(cv::Mat& picture, const Marker& marker, const Pose& robot, const CameraGeometry& camera) {
  // From behind, nothing is seen.
  if (std::cos(marker.rho) * (robot.x - marker.at.x) +
          std::sin(marker.rho) * (robot.y - marker.at.y) <=
      0)
    return;
  const auto look = picture_of(marker);
  if (!look) return;
  const cv::Mat cells(look->side, look->side, CV_8U, const_cast<std::uint8_t*>(look->cells.data()));
  cv::Mat print;
  cv::resize(cells, print, {}, kCell, kCell, cv::INTER_NEAREST);
  const double half = marker.size * look->whole / 2;
  std::array<cv::Point2f, 4> to;
  const std::array<std::array<double, 2>, 4> signs = {{{-1, 1}, {1, 1}, {1, -1}, {-1, -1}}};
  for (std::size_t i = 0; i < to.size(); ++i) {
    const auto [right, up] = signs.at(i);
    const double x = marker.at.x + right * half * std::sin(marker.rho) - robot.x;
    const double y = marker.at.y - right * half * std::cos(marker.rho) - robot.y;
    const double c = std::cos(robot.rho);
    const double s = std::sin(robot.rho);
    const auto pixel = camera.pixel({c * x + s * y, c * y - s * x, -(marker.height + up * half)});
    if (!pixel) return;
    to.at(i) = {static_cast<float>(pixel->column), static_cast<float>(pixel->row)};
  }
  const auto side = static_cast<float>(print.cols);
  const std::array<cv::Point2f, 4> from = {{{0, 0}, {side, 0}, {side, side}, {0, side}}};
  // Centres of pixels are half a pixel from their edges, which the matrix counts from.
  const cv::Matx33d shift(1, 0, -0.5, 0, 1, -0.5, 0, 0, 1);
  const cv::Matx33d unshift(1, 0, 0.5, 0, 1, 0.5, 0, 0, 1);
  const cv::Mat whole = cv::getPerspectiveTransform(from.data(), to.data());
  const cv::Matx33d matrix = shift * cv::Matx33d(whole) * unshift;
  // Four times as fine as the picture, so that edges are as grey as they are for a camera.
  constexpr int kFine = 4;
  const cv::Matx33d fine(kFine, 0, (kFine - 1) / 2.0, 0, kFine, (kFine - 1) / 2.0, 0, 0, 1);
  cv::Mat drawn(picture.rows * kFine, picture.cols * kFine, CV_8U, cv::Scalar(kWall));
  cv::Mat mask(drawn.size(), CV_8U, cv::Scalar(0));
  cv::warpPerspective(print, drawn, fine * matrix, drawn.size(), cv::INTER_LINEAR,
                      cv::BORDER_TRANSPARENT);
  cv::warpPerspective(cv::Mat(print.size(), CV_8U, cv::Scalar(255)), mask, fine * matrix,
                      mask.size());
  cv::resize(drawn, drawn, picture.size(), 0, 0, cv::INTER_AREA);
  cv::resize(mask, mask, picture.size(), 0, 0, cv::INTER_AREA);
  drawn.copyTo(picture, mask > 0);
}

}  // namespace

Rendered rendered(std::span<const Marker> markers, const Pose& pose, const CameraGeometry& camera,
                  double noise, double blur) {
  Rendered made;
  cv::Mat picture(made.height, made.width, CV_8U, cv::Scalar(kWall));
  for (const Marker& marker : markers) draw(picture, marker, pose, camera);
  if (blur > 0) cv::GaussianBlur(picture, picture, {}, blur);
  if (noise > 0) {
    cv::Mat grains(picture.size(), CV_16S);
    cv::RNG random(7);
    random.fill(grains, cv::RNG::NORMAL, 0, noise);
    cv::add(picture, grains, picture, cv::noArray(), CV_8U);
  }
  made.pixels.assign(picture.datastart, picture.dataend);
  return made;
}

CameraGeometry test_camera(const Pose& mounting) {
  constexpr i32 kWidth = 640;
  constexpr i32 kHeight = 480;
  CameraParamData parameters;
  parameters.calibration_width = kWidth;
  parameters.calibration_height = kHeight;
  parameters.fx = parameters.fy = 554.3F;
  parameters.e0 = 320;
  parameters.n0 = 240;
  return *CameraGeometry::make(parameters, kWidth, kHeight, mounting);
}

}  // namespace rack::vision
