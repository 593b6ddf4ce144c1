// Where something is and where it looks, and how poses follow from each other. Pure.
#pragma once

#include "components/geometry/angle.h"
#include "rack/proxies/geometry.h"

namespace rack {

// As a Position3d, but with fractions: what is added up a million times must not be rounded.
struct Pose {
  double x = 0;    // mm
  double y = 0;    // mm
  double z = 0;    // mm
  double phi = 0;  // rad
  double psi = 0;  // rad
  double rho = 0;  // rad

  static Pose of(const Position3d& position);
  // Rounded to millimetres, angles normalised.
  [[nodiscard]] Position3d position() const;
};

// `local`, said in the frame `frame`, as its surroundings see it. Frames turn about z only.
Pose operator+(const Pose& frame, const Pose& local);
// What has to be added to `from` to get `to`: from + (to - from) is `to`.
Pose operator-(const Pose& to, const Pose& from);

// `part` 0: a, 1: b; less and more go on beyond. Angles take the short way.
Pose between(const Pose& a, const Pose& b, double part);

}  // namespace rack
