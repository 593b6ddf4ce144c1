#include "components/vision/marker_pose.h"

#include <cmath>

#include <opencv2/calib3d.hpp>

#include "components/pictures/opencv_call.h"

namespace rack::vision {

using scan3d::Place;

namespace {

// OpenCV's axes: x to the right, y down, z forward.
Place forward_first(const cv::Vec3d& v) { return {v[2], v[0], v[1]}; }

// The marker's axes: x to the right, y up, z out of its face.
MarkerPose pose(const cv::Vec3d& rotation, const cv::Vec3d& translation, double error,
                const CameraGeometry& camera) {
  cv::Matx33d axes;
  cv::Rodrigues(rotation, axes);
  const Place at = camera.on_robot(forward_first(translation));
  const cv::Vec3d face(axes(0, 2), axes(1, 2), axes(2, 2));
  const Place before = camera.on_robot(forward_first(translation + face));
  return {.at = at, .rho = heading(std::atan2(before.y - at.y, before.x - at.x)), .error = error};
}

}  // namespace

tims::Result<std::array<MarkerPose, 2>> poses_of(const Sighting& sighting, double size,
                                                 const CameraGeometry& camera) {
  const double half = size / 2;
  const std::array<cv::Point3d, 4> square = {
      {cv::Point3d(-half, half, 0), cv::Point3d(half, half, 0), cv::Point3d(half, -half, 0),
       cv::Point3d(-half, -half, 0)}};
  std::array<cv::Point2d, 4> corners;
  for (std::size_t i = 0; i < corners.size(); ++i)
    corners.at(i) = {sighting.corners.at(i).column, sighting.corners.at(i).row};
  const Lens& lens = camera.lens();
  const cv::Matx33d matrix(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1);
  std::vector<cv::Vec3d> rotations;
  std::vector<cv::Vec3d> translations;
  std::vector<double> errors;
  const auto done = pictures::call_opencv("the pose of a marker", [&] {
    cv::solvePnPGeneric(square, corners, matrix, cv::noArray(), rotations, translations, false,
                        cv::SOLVEPNP_IPPE_SQUARE, cv::noArray(), cv::noArray(), errors);
  });
  if (!done) return done.error();
  if (rotations.size() != 2)
    return tims::Error(tims::Errc::kMalformed, "the corners are not those of a square");
  std::array<MarkerPose, 2> poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses.at(i) = pose(rotations[i], translations[i], errors[i], camera);
    if (!std::isfinite(poses.at(i).at.x + poses.at(i).at.y + poses.at(i).at.z + poses.at(i).rho))
      return tims::Error(tims::Errc::kMalformed, "the corners are not those of a square");
  }
  return poses;
}

}  // namespace rack::vision
