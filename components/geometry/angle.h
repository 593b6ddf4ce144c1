// Angles as messages want them (specification, section 9): rho from 0 to 2 pi, others around 0.
#pragma once

#include <cmath>
#include <numbers>

namespace rack {

inline constexpr double kPi = std::numbers::pi;

constexpr double radians(double degrees) { return degrees * kPi / 180; }
constexpr double degrees(double radians) { return radians * 180 / kPi; }

// 0 to 2 pi, the latter excluded; what is no number becomes 0.
inline double heading(double angle) {
  const double rest = std::fmod(angle, 2 * kPi);
  if (!std::isfinite(rest)) return 0;
  const double positive = rest < 0 ? rest + 2 * kPi : rest;
  return positive < 2 * kPi ? positive : 0;  // a tiny negative one
}

// -pi to pi, the former excluded.
inline double signed_angle(double angle) {
  const double positive = heading(angle);
  return positive > kPi ? positive - 2 * kPi : positive;
}

}  // namespace rack
