// The pose of the robot from markers of a map that its camera sees.
//
// The robot is on the ground and the place of the camera on it is known, so that only x, y and the
// heading are unknown. Each marker alone gives two poses (marker_pose.h). Each of them is refined
// to the pose for which the corners of its marker are where they are in the picture (least squares,
// Gauss-Newton); then all markers whose corners agree are included. The pose that most markers
// agree with wins. Where a single marker fits two poses nearly equally well, both are returned.
// Pure.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "components/vision/marker_map.h"
#include "components/vision/marker_pose.h"

namespace rack::vision {

// A marker of the map that is in the picture.
struct Landmark {
  Marker marker{};
  std::array<ImagePoint, 4> corners{};
  std::array<MarkerPose, 2> poses{};
};

struct RobotFix {
  Pose pose{};               // x, y, rho in the map
  double deviation = 0;      // mm, standard deviation of x and y: the larger one
  double deviation_rho = 0;  // rad
  double error = 0;          // of the corners, root mean square, pixels
  std::size_t markers = 0;   // that agree
};

// The best one first; empty: no marker fits. More than one: they cannot be told apart.
std::vector<RobotFix> fixes_of(std::span<const Landmark> landmarks, const CameraGeometry& camera);

}  // namespace rack::vision
