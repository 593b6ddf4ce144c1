// Angles and poses in the plane, clockwise as in RACK. Pure.
#pragma once

#include <cmath>
#include <numbers>

#include "rack/proxies/geometry.h"

namespace rack {

// --- Angles as in messages (specification, section 9): rho from 0 to 2 pi, others around 0.

inline constexpr double kPi = std::numbers::pi;

constexpr double radians(double degrees) { return degrees * kPi / 180; }
constexpr double degrees(double radians) { return radians * 180 / kPi; }

// 0 to 2 pi, the latter excluded; 0 for values that are not numbers.
inline double heading(double angle) {
  const double rest = std::fmod(angle, 2 * kPi);
  if (!std::isfinite(rest)) return 0;
  const double positive = rest < 0 ? rest + 2 * kPi : rest;
  return positive < 2 * kPi ? positive : 0;  // a tiny negative angle was rounded up
}

// -pi to pi, the former excluded.
inline double signed_angle(double angle) {
  const double positive = heading(angle);
  return positive > kPi ? positive - 2 * kPi : positive;
}

// The unit of lengths in messages.
inline i32 whole_millimetres(double mm) { return Millimetres<i32>::from_si(mm / 1000); }

// --- Poses and their composition.

// A Position3d with fractions: sums of millions of steps must not be rounded.
struct Pose {
  double x = 0;    // mm
  double y = 0;    // mm
  double z = 0;    // mm
  double phi = 0;  // rad
  double psi = 0;  // rad
  double rho = 0;  // rad

  static Pose of(const Position3d& position);
  static Pose of(const Position2d& position);
  // Rounded to millimetres, angles normalised.
  [[nodiscard]] Position3d position() const;
};

// Transforms `local` from the frame `frame` to the parent of the frame. Frames turn about z only.
Pose operator+(const Pose& frame, const Pose& local);
// The pose relative to `from`: from + (to - from) is `to`.
Pose operator-(const Pose& to, const Pose& from);

// A movement in the frame of the vehicle that makes it.
struct Movement {
  double x = 0;    // mm, forward
  double y = 0;    // mm, to the right
  double rho = 0;  // rad
};
// The pose after a short movement that turns evenly along its path. Full turns are kept in rho.
Pose moved(const Pose& from, const Movement& by);

// Interpolates: `part` 0: a, 1: b; other values extrapolate. Angles take the shorter arc.
Pose between(const Pose& a, const Pose& b, double part);

}  // namespace rack
