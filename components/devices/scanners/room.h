// Default scene of emulated range finders: a rectangular room with the scanner in it.
#pragma once

#include <algorithm>
#include <cmath>

#include "components/devices/core/scene.h"

namespace rack::device::emulator {

struct Room {
  double ahead = 3000;  // distances of the walls from the scanner, mm
  double behind = 2000;
  double right = 1500;
  double left = 2500;

  // Distance at an angle clockwise from straight ahead; rad, mm.
  [[nodiscard]] double distance(double angle) const {
    const double forward = std::cos(angle);
    const double sideways = std::sin(angle);
    constexpr double kParallel = 1e-9;
    double nearest = kNothing;
    if (forward > kParallel) nearest = std::min(nearest, ahead / forward);
    if (forward < -kParallel) nearest = std::min(nearest, behind / -forward);
    if (sideways > kParallel) nearest = std::min(nearest, right / sideways);
    if (sideways < -kParallel) nearest = std::min(nearest, left / -sideways);
    return nearest;
  }
  // For use as a Sight: the walls have infinite height.
  double operator()(double angle, double elevation, Time /*when*/) const {
    return distance(angle) / std::cos(elevation);
  }
};

}  // namespace rack::device::emulator
