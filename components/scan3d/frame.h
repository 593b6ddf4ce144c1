// Points in space, and frames that are translated and rotated: for a turning scanner on a robot
// that rolls and pitches, for which poses in the plane (components/geometry) are not sufficient.
// Pure.
//
// RACK's axes are x forward, y right, z down; angles are clockwise when looking along their axis. A
// pose rotates about x (phi), then y (psi), then z (rho), and translates last.
#pragma once

#include <array>
#include <cmath>

#include "components/geometry/pose.h"

namespace rack::scan3d {

struct Place {  // mm, or a direction
  double x = 0;
  double y = 0;
  double z = 0;

  friend Place operator+(const Place& a, const Place& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  friend Place operator*(const Place& a, double by) { return {a.x * by, a.y * by, a.z * by}; }
};

class Frame {
 public:
  Frame() = default;
  explicit Frame(const Pose& pose)
      : Frame(about_z(pose.rho) * about_y(pose.psi) * about_x(pose.phi)) {
    origin_ = {pose.x, pose.y, pose.z};
  }

  static Frame about_x(double angle) {
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return Frame({{{1, 0, 0}, {0, c, -s}, {0, s, c}}});
  }
  static Frame about_y(double angle) {
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return Frame({{{c, 0, s}, {0, 1, 0}, {-s, 0, c}}});
  }
  static Frame about_z(double angle) {
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return Frame({{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}});
  }

  // Transforms a point from this frame to its parent frame.
  Place operator*(const Place& local) const { return turned(local) + origin_; }
  Frame operator*(const Frame& local) const {
    Frame made;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        made.rows_[i][k] = 0;
        for (std::size_t j = 0; j < 3; ++j) made.rows_[i][k] += rows_[i][j] * local.rows_[j][k];
      }
    made.origin_ = *this * local.origin_;
    return made;
  }
  [[nodiscard]] Frame inverse() const {
    Frame made;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) made.rows_[i][k] = rows_[k][i];
    made.origin_ = made.turned(origin_) * -1;
    return made;
  }

 private:
  using Rows = std::array<std::array<double, 3>, 3>;
  explicit Frame(const Rows& rows) : rows_(rows) {}

  [[nodiscard]] Place turned(const Place& a) const {
    const auto row = [&](std::size_t i) {
      return rows_[i][0] * a.x + rows_[i][1] * a.y + rows_[i][2] * a.z;
    };
    return {row(0), row(1), row(2)};
  }

  Rows rows_{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Place origin_{};
};

}  // namespace rack::scan3d
