#include "components/geometry/pose.h"

#include <cmath>

namespace rack {

Pose Pose::of(const Position3d& position) {
  return {static_cast<double>(position.x.raw()),
          static_cast<double>(position.y.raw()),
          static_cast<double>(position.z.raw()),
          position.phi.raw(),
          position.psi.raw(),
          position.rho.raw()};
}

Pose Pose::of(const Position2d& position) {
  return {.x = static_cast<double>(position.x.raw()),
          .y = static_cast<double>(position.y.raw()),
          .rho = position.rho.raw()};
}

Position3d Pose::position() const {
  return {.x = whole_millimetres(x),
          .y = whole_millimetres(y),
          .z = whole_millimetres(z),
          .phi = static_cast<f32>(signed_angle(phi)),
          .psi = static_cast<f32>(signed_angle(psi)),
          .rho = static_cast<f32>(heading(rho))};
}

Pose operator+(const Pose& frame, const Pose& local) {
  const double c = std::cos(frame.rho);
  const double s = std::sin(frame.rho);
  return {frame.x + local.x * c - local.y * s,
          frame.y + local.x * s + local.y * c,
          frame.z + local.z,
          frame.phi + local.phi,
          frame.psi + local.psi,
          heading(frame.rho + local.rho)};
}

Pose operator-(const Pose& to, const Pose& from) {
  const double c = std::cos(from.rho);
  const double s = std::sin(from.rho);
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  return {dx * c + dy * s,   dy * c - dx * s,   to.z - from.z,
          to.phi - from.phi, to.psi - from.psi, heading(to.rho - from.rho)};
}

Pose moved(const Pose& from, const Movement& by) {
  const double middle = from.rho + by.rho / 2;
  return {.x = from.x + by.x * std::cos(middle) - by.y * std::sin(middle),
          .y = from.y + by.x * std::sin(middle) + by.y * std::cos(middle),
          .z = from.z,
          .phi = from.phi,
          .psi = from.psi,
          .rho = from.rho + by.rho};
}

Pose between(const Pose& a, const Pose& b, double part) {
  const auto line = [part](double from, double to) { return from + (to - from) * part; };
  const auto turn = [part](double from, double to) {
    return from + signed_angle(to - from) * part;
  };
  return {line(a.x, b.x),
          line(a.y, b.y),
          line(a.z, b.z),
          signed_angle(turn(a.phi, b.phi)),
          signed_angle(turn(a.psi, b.psi)),
          heading(turn(a.rho, b.rho))};
}

}  // namespace rack
