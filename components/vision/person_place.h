// The place of a person from the box in the picture.
//
// There are two measures of the distance. The feet: the ray to them meets the ground there, which
// needs a flat ground and the height of the lens. The size: a person of known height who appears
// half as tall is twice as far away. Both are linear in the inverse of the distance, so their
// errors are combined there, weighted by their variances. If they contradict each other, no person
// of that height stands on the ground. Pure.
#pragma once

#include <optional>

#include "components/vision/camera_geometry.h"
#include "components/vision/people_finder.h"

namespace rack::vision {

struct PersonMeasures {
  double height = 1750;      // mm
  double deviation = 100;    // mm, standard deviation of the height
  double range_max = 10000;  // mm, from the lens along the ground
};

// In the robot's frame.
struct PersonPlace {
  double x = 0;  // mm
  double y = 0;
  double range = 0;             // mm, from the lens along the ground
  double direction = 0;         // of the line of sight, rad
  double deviation_range = 0;   // standard deviation, mm
  double deviation_across = 0;  // mm
  double height = 0;            // of the person, as it appears at that distance, mm
};

// `picture_height`: pixels; feet below the picture are not measured. Empty: nearer than 300 mm,
// beyond range_max, or not a person of about that height on the ground.
std::optional<PersonPlace> place_of(const PersonBox& box, const CameraGeometry& camera,
                                    int picture_height, const PersonMeasures& measures);

// The height in the picture of a person at a distance, pixels.
double apparent_height(double height, double range, const CameraGeometry& camera);

}  // namespace rack::vision
