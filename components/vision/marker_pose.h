// The pose of a marker from its corners in a picture.
//
// A square that is small in the picture looks nearly the same when it is mirrored about the plane
// across the line of sight: there are two poses that fit, and noise decides which one fits better.
// Both are returned, the better one first (T. Collins, A. Bartoli, "Infinitesimal Plane-Based Pose
// Estimation", 2014; OpenCV's SOLVEPNP_IPPE_SQUARE).
#pragma once

#include <array>

#include "components/vision/marker_finder.h"

namespace rack::vision {

// In the robot's frame.
struct MarkerPose {
  scan3d::Place at{};  // its centre
  double rho = 0;      // direction that its face looks to
  double error = 0;    // of its corners in the picture, root mean square, pixels
};

// `size`: side of the marker, mm. The error kMalformed: the corners are not those of a square.
tims::Result<std::array<MarkerPose, 2>> poses_of(const Sighting& sighting, double size,
                                                 const CameraGeometry& camera);

}  // namespace rack::vision
