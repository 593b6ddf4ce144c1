#include "components/world/render/artist.h"

#include <algorithm>
#include <cmath>

#include "components/geometry/pose.h"

namespace rack::world {

namespace {

constexpr int kSidesMax = 12;

Point3 sum(const Point3& a, const Point3& b, double factor = 1) {
  return {a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]};
}
Point3 product(const Point3& a, const Point3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Point3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }
Point3 unit(const Point3& v) {
  const double size = length(v);
  return size > 0 ? Point3{v[0] / size, v[1] / size, v[2] / size} : Point3{1, 0, 0};
}

}  // namespace

// Diffuse light from all sides, more of it from above, and some from one direction, so that the
// sides of a corner differ.
double Artist::light(const Point3& normal) {
  const Point3 n = unit(normal);
  constexpr Point3 kLamp{0.48, 0.36, -0.8};
  const double lamp = n[0] * kLamp[0] + n[1] * kLamp[1] + n[2] * kLamp[2];
  return 0.74 + 0.24 * lamp - 0.08 * n[2];
}

std::array<double, 3> Artist::seen(const Point3& at) const {
  const Point3 d = sum(at, view_.from, -1);
  const auto along = [&](std::size_t axis) {
    return d[0] * view_.turn[0][axis] + d[1] * view_.turn[1][axis] + d[2] * view_.turn[2][axis];
  };
  return {along(1), along(2), along(0)};
}

double Artist::distance_to(const MapPoint& at) const {
  return std::hypot(at.x - view_.from[0], at.y - view_.from[1]);
}

int Artist::sides_at(double distance) const {
  constexpr double kFar = 15000;
  constexpr int kSidesFar = 6;
  return distance > kFar ? kSidesFar : kSidesMax;
}

void Artist::polygon(std::span<const Spot> spots, double light, const Paint& paint) {
  std::array<Corner, 4> corners{};
  const std::size_t count = std::min(spots.size(), corners.size());
  for (std::size_t i = 0; i < count; ++i)
    corners[i] = {seen(spots[i].at), spots[i].u, spots[i].v, light * spots[i].light};
  raster_.draw(std::span(corners).first(count), paint);
}

void Artist::box(const Box& box, double low, double high, const Texture& texture) {
  const auto corner = [&](double length, double width) {
    return MapPoint{box.at.x + length * box.c - width * box.s,
                    box.at.y + length * box.s + width * box.c};
  };
  const double l = box.half_length;
  const double w = box.half_width;
  const std::array<MapPoint, 4> base = {corner(l, -w), corner(l, w), corner(-l, w), corner(-l, -w)};
  const double side = texture.levels().front().width;
  const Paint paint{.texture = &texture};
  for (std::size_t i = 0; i < 4; ++i) {
    const MapPoint& right = base.at(i);
    const MapPoint& left = base.at((i + 1) % 4);
    const Point3 normal{left.y - right.y, right.x - left.x, 0};
    polygon(std::array{Spot{point(left, high), 0, 0}, Spot{point(right, high), side, 0},
                       Spot{point(right, low), side, side}, Spot{point(left, low), 0, side}},
            light(normal), paint);
  }
  polygon(std::array{Spot{point(base[0], high), 0, 0}, Spot{point(base[1], high), side, 0},
                     Spot{point(base[2], high), side, side}, Spot{point(base[3], high), 0, side}},
          light({0, 0, -1}), paint);
}

void Artist::cylinder(const MapPoint& at, double radius, double height, const Texture& texture) {
  const std::array rings = {Ring{0, radius, radius}, Ring{1, radius, radius}, Ring{1, 0, 0}};
  tube(point(at, 0), point(at, height), {1, 0, 0}, rings, texture);
}

void Artist::tube(const Point3& low, const Point3& high, const Point3& forward,
                  std::span<const Ring> rings, const Texture& texture) {
  const Point3 axis = sum(high, low, -1);
  const Point3 down = unit({-axis[0], -axis[1], -axis[2]});
  const Point3 right = unit(product(down, forward));
  const Point3 ahead = product(right, down);
  const int sides = sides_at(distance_to({low[0], low[1]}));
  // Of one ring: corners, clockwise when seen from its upper end.
  const auto corners_of = [&](const Ring& ring, const Ring& next) {
    std::array<Corner, kSidesMax> corners;
    const Point3 middle = sum(low, axis, ring.at);
    // A tube that becomes thinner upwards is lit from above, as its surface leans back.
    const double rise = (next.at - ring.at) * length(axis);
    for (int i = 0; i < sides; ++i) {
      const double angle = 2 * kPi * i / sides;
      const double c = std::cos(angle);
      const double s = std::sin(angle);
      const Point3 around = sum({}, sum({ahead[0] * c * ring.forward, ahead[1] * c * ring.forward,
                                         ahead[2] * c * ring.forward},
                                        right, s * ring.side));
      const Point3 outside = sum({ahead[0] * c, ahead[1] * c, ahead[2] * c}, right, s);
      const double lean =
          std::hypot(c * (ring.forward - next.forward), s * (ring.side - next.side));
      const bool narrows = ring.forward + ring.side > next.forward + next.side;
      const Point3 normal = sum(
          {outside[0] * std::abs(rise), outside[1] * std::abs(rise), outside[2] * std::abs(rise)},
          down, narrows ? -lean : lean);
      corners.at(static_cast<std::size_t>(i)) = {seen(sum(middle, around)), 0, 0, light(normal)};
    }
    return corners;
  };
  const double width = texture.levels().front().width;
  const double height = texture.levels().front().height;
  const Paint paint{.texture = &texture};
  for (std::size_t k = 0; k + 1 < rings.size(); ++k) {
    auto lower = corners_of(rings[k], rings[k + 1]);
    auto upper = corners_of(rings[k + 1], k + 2 < rings.size() ? rings[k + 2] : rings[k + 1]);
    if (k + 2 >= rings.size())
      for (std::size_t i = 0; i < upper.size(); ++i) upper.at(i).light = lower.at(i).light;
    for (int i = 0; i < sides; ++i) {
      const auto left = static_cast<std::size_t>((i + 1) % sides);
      const auto right_one = static_cast<std::size_t>(i);
      const auto with = [&](Corner corner, double part, double share) {
        corner.u = width * part / sides;
        corner.v = height * (1 - share);
        return corner;
      };
      const Corner a = with(upper.at(left), i + 1, rings[k + 1].at);
      const Corner b = with(upper.at(right_one), i, rings[k + 1].at);
      const Corner c = with(lower.at(right_one), i, rings[k].at);
      const Corner d = with(lower.at(left), i + 1, rings[k].at);
      raster_.draw(std::array{a, b, c}, paint);
      raster_.draw(std::array{a, c, d}, paint);
    }
  }
}

void Artist::ellipsoid(const Point3& middle, const Point3& forward, const Ring& radii,
                       double height, const Texture& texture) {
  constexpr std::size_t kRings = 7;
  std::array<Ring, kRings> rings{};
  for (std::size_t i = 0; i < kRings; ++i) {
    const double angle = kPi * (static_cast<double>(i) / (kRings - 1) - 0.5);
    rings.at(i) = {(1 + std::sin(angle)) / 2, radii.forward * std::cos(angle),
                   radii.side * std::cos(angle)};
  }
  tube(sum(middle, {0, 0, 1}, height / 2), sum(middle, {0, 0, -1}, height / 2), forward, rings,
       texture);
}

void Artist::shadow(const MapPoint& at, double rho, double half_length, double half_width) {
  constexpr double kDark = 0.62;
  constexpr double kAhead = 10;  // mm, before the floor
  const double c = std::cos(rho);
  const double s = std::sin(rho);
  std::array<Corner, kSidesMax> rim{};
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const double angle = 2 * kPi * static_cast<double>(i) / kSidesMax;
    const double x = half_length * std::cos(angle);
    const double y = half_width * std::sin(angle);
    rim.at(i) = {seen(point({at.x + x * c - y * s, at.y + x * s + y * c}, 0)), 0, 0, 1};
  }
  const Corner middle{seen(point(at, 0)), 0, 0, kDark};
  const Paint paint{.both_sides = true, .is_shadow = true, .nearer = kAhead};
  for (std::size_t i = 0; i < rim.size(); ++i)
    raster_.draw(std::array{middle, rim.at(i), rim.at((i + 1) % rim.size())}, paint);
}

}  // namespace rack::world
