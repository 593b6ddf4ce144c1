#include "components/path/reeds_shepp.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rack::path {

namespace {

constexpr double kQuarter = kPi / 2;
constexpr double kTiny = 1e-10;

// The goal in units of the radius, in the frame of the start.
struct Target {
  double x;
  double y;
  double phi;
};

// The lengths of the parts of a path, negative backward.
struct Lengths {
  std::array<double, 5> of{};
  bool good = false;
};

// For sums of a few angles: faster than a division.
double mod(double angle) {
  while (angle > kPi) angle -= 2 * kPi;
  while (angle <= -kPi) angle += 2 * kPi;
  return std::abs(angle) < kTiny ? 0 : angle;
}

Lengths found(bool good, double a, double b, double c, double d = 0, double e = 0) {
  return {{a, b, c, d, e}, good};
}

// The relative position of the centres of the first and the last circle: on the same side, and on
// different sides.
struct Centers {
  double xi;
  double eta;
  [[nodiscard]] double away() const { return std::hypot(xi, eta); }
  [[nodiscard]] double bearing() const { return std::atan2(eta, xi); }
};
Centers same(const Target& t) { return {t.x - std::sin(t.phi), t.y - 1 + std::cos(t.phi)}; }
Centers other(const Target& t) { return {t.x + std::sin(t.phi), t.y - 1 - std::cos(t.phi)}; }

Lengths lsl(const Target& target) {  // 8.1
  const Centers c = same(target);
  const double t = mod(c.bearing());
  const double v = mod(target.phi - t);
  return found(t >= 0 && v >= 0, t, c.away(), v);
}

Lengths lsr(const Target& target) {  // 8.2
  const Centers c = other(target);
  const double square = c.away() * c.away();
  if (square < 4) return {};
  const double u = std::sqrt(square - 4);
  const double t = mod(c.bearing() + std::atan2(2, u));
  const double v = mod(t - target.phi);
  return found(t >= 0 && v >= 0, t, u, v);
}

Lengths lrl(const Target& target) {  // 8.3, 8.4
  const Centers c = same(target);
  if (c.away() > 4) return {};
  const double u = -2 * std::asin(c.away() / 4);
  const double t = mod(c.bearing() + u / 2 + kPi);
  const double v = mod(target.phi - t + u);
  return found(t >= 0 && u <= 0, t, u, v);
}

struct Ends {
  double t;
  double v;
};
Ends ends_of_four(double u, double v, const Centers& c, double phi) {
  const double delta = mod(u - v);
  const double a = std::sin(u) - std::sin(delta);
  const double b = std::cos(u) - std::cos(delta) - 1;
  const double first = std::atan2(c.eta * a - c.xi * b, c.xi * a + c.eta * b);
  const double second = 2 * (std::cos(delta) - std::cos(v) - std::cos(u)) + 3;
  const double tau = mod(second < 0 ? first + kPi : first);
  return {tau, mod(tau - u + v - phi)};
}

Lengths lrlr_middle_there_and_back(const Target& target) {  // 8.7
  const Centers c = other(target);
  const double rho = (2 + c.away()) / 4;
  if (rho > 1) return {};
  const double u = std::acos(rho);
  const Ends ends = ends_of_four(u, -u, c, target.phi);
  return found(ends.t >= 0 && ends.v <= 0, ends.t, u, -u, ends.v);
}

Lengths lrlr_middle_back(const Target& target) {  // 8.8
  const Centers c = other(target);
  const double rho = (20 - c.away() * c.away()) / 16;
  if (rho < 0 || rho > 1) return {};
  const double u = -std::acos(rho);
  const Ends ends = ends_of_four(u, u, c, target.phi);
  return found(ends.t >= 0 && ends.v >= 0, ends.t, u, u, ends.v);
}

Lengths lrsl(const Target& target) {  // 8.9
  const Centers c = same(target);
  if (c.away() < 2) return {};
  const double r = std::sqrt(c.away() * c.away() - 4);
  const double u = 2 - r;
  const double t = mod(c.bearing() + std::atan2(r, -2));
  const double v = mod(target.phi - kQuarter - t);
  return found(t >= 0 && u <= 0 && v <= 0, t, -kQuarter, u, v);
}

Lengths lrsr(const Target& target) {  // 8.10
  const Centers c = other(target);
  if (c.away() < 2) return {};
  const double t = mod(std::atan2(c.xi, -c.eta));
  const double u = 2 - c.away();
  const double v = mod(t + kQuarter - target.phi);
  return found(t >= 0 && u <= 0 && v <= 0, t, -kQuarter, u, v);
}

Lengths lrslr(const Target& target) {  // 8.11
  const Centers c = other(target);
  if (c.away() < 2) return {};
  const double u = 4 - std::sqrt(c.away() * c.away() - 4);
  if (u > 0) return {};
  const double t = mod(std::atan2((4 - u) * c.xi - 2 * c.eta, -2 * c.xi + (u - 4) * c.eta));
  const double v = mod(t - target.phi);
  return found(t >= 0 && v >= 0, t, -kQuarter, u, -kQuarter, v);
}

// A turn to the positive side is 1, a line 0.
struct Family {
  Lengths (*solve)(const Target&);
  std::size_t parts;
  std::array<int, 5> sides;
  bool from_both_ends;
};
constexpr std::array<Family, 8> kFamilies = {{
    {lsl, 3, {1, 0, 1}, false},
    {lsr, 3, {1, 0, -1}, false},
    {lrl, 3, {1, -1, 1}, true},
    {lrlr_middle_there_and_back, 4, {1, -1, 1, -1}, false},
    {lrlr_middle_back, 4, {1, -1, 1, -1}, false},
    {lrsl, 4, {1, -1, 0, 1}, true},
    {lrsr, 4, {1, -1, 0, -1}, true},
    {lrslr, 5, {1, -1, 0, 1, -1}, false},
}};

}  // namespace

ReedsShepp::ReedsShepp(const Pose& from, const Pose& to, double radius) {
  const Pose seen = to - from;
  const Target target{seen.x / radius, seen.y / radius, signed_angle(to.rho - from.rho)};
  double best = std::numeric_limits<double>::infinity();
  for (const Family& family : kFamilies) {
    for (const bool reversed : {false, true}) {
      if (reversed && !family.from_both_ends) continue;
      Target base = target;
      if (reversed) {
        const double c = std::cos(target.phi);
        const double s = std::sin(target.phi);
        base = {target.x * c + target.y * s, target.x * s - target.y * c, target.phi};
      }
      for (const double time : {1.0, -1.0}) {
        for (const double side : {1.0, -1.0}) {
          const Lengths lengths =
              family.solve({time * base.x, side * base.y, time * side * base.phi});
          if (!lengths.good) continue;
          double sum = 0;
          for (const double part : lengths.of) sum += std::abs(part);
          if (sum >= best) continue;
          best = sum;
          count_ = family.parts;
          for (std::size_t i = 0; i < count_; ++i) {
            const std::size_t k = reversed ? count_ - 1 - i : i;
            pieces_[i] = {side * family.sides[k] / radius, time * lengths.of[k] * radius};
          }
        }
      }
    }
  }
  length_ = best * radius;
}

Pose driven(const Pose& from, const Piece& piece) {
  const double turn = piece.curvature * piece.length;
  const double chord =
      std::abs(turn) < 1e-9 ? piece.length : 2 * std::sin(turn / 2) / piece.curvature;
  const double middle = from.rho + turn / 2;
  return {.x = from.x + chord * std::cos(middle),
          .y = from.y + chord * std::sin(middle),
          .rho = from.rho + turn};
}

}  // namespace rack::path
