#include "components/world/core/shapes.h"

#include <array>

namespace rack::world {

namespace {

constexpr double kCorner = 1e-3;  // mm: no ray passes between joined walls (as in FloorMap)
constexpr double kNearlyStraight = 1e-6;

struct Span {
  double low;
  double high;
};

bool apart(const Span& a, const Span& b) { return a.high <= b.low || b.high <= a.low; }

std::array<MapPoint, 4> corners(const Box& box) {
  std::array<MapPoint, 4> points;
  constexpr std::array<std::array<double, 2>, 4> kSides = {{{1, 1}, {1, -1}, {-1, -1}, {-1, 1}}};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x = kSides[i][0] * box.half_length;
    const double y = kSides[i][1] * box.half_width;
    points[i] = {box.at.x + x * box.c - y * box.s, box.at.y + x * box.s + y * box.c};
  }
  return points;
}

// Whether an edge of `of` separates all points of the other.
template <typename Points>
bool separates(const Box& of, const Points& others) {
  Span x{kNoHit, -kNoHit};
  Span y{kNoHit, -kNoHit};
  for (const MapPoint& point : others) {
    const MapPoint local = of.local(point);
    x = {std::min(x.low, local.x), std::max(x.high, local.x)};
    y = {std::min(y.low, local.y), std::max(y.high, local.y)};
  }
  return apart(x, {-of.half_length, of.half_length}) || apart(y, {-of.half_width, of.half_width});
}

}  // namespace

Solid Solid::of(const ObstacleDescription& obstacle) {
  Solid solid;
  solid.shape = obstacle.shape;
  solid.circle = {obstacle.at, obstacle.radius};
  solid.box = Box::of(obstacle.at, obstacle.rho, obstacle.length, obstacle.width);
  solid.height = obstacle.height;
  return solid;
}

Inside inside(const Ray& ray, const Circle& circle) {
  const double x = circle.at.x - ray.from.x;
  const double y = circle.at.y - ray.from.y;
  const double ahead = x * ray.x + y * ray.y;
  const double aside = x * ray.y - y * ray.x;
  const double square = circle.radius * circle.radius - aside * aside;
  if (square <= 0) return {};
  const double half = std::sqrt(square);
  return {ahead - half, ahead + half};
}

Inside inside(const Ray& ray, const Box& box) {
  const MapPoint from = box.local(ray.from);
  const double dx = ray.x * box.c + ray.y * box.s;
  const double dy = ray.y * box.c - ray.x * box.s;
  Inside span{-kNoHit, kNoHit};
  const auto slab = [&span](double at, double direction, double half) {
    if (direction == 0) {
      if (std::abs(at) > half) span = {};
      return;
    }
    const double one = (-half - at) / direction;
    const double other = (half - at) / direction;
    span.from = std::max(span.from, std::min(one, other));
    span.to = std::min(span.to, std::max(one, other));
  };
  slab(from.x, dx, box.half_length);
  slab(from.y, dy, box.half_width);
  return span;
}

double meets(const Ray& ray, const Inside& inside, double height) {
  if (inside.from > inside.to || inside.to < 0) return kNoHit;
  const double enters = std::max(inside.from, 0.0);
  const double at_side = ray.height_at(enters);
  if (at_side < 0) return kNoHit;  // it hits the ground first
  if (at_side <= height) return enters;
  if (ray.climb >= 0) return kNoHit;
  const double at_top = (height - ray.height) / ray.climb;
  return at_top <= inside.to ? at_top : kNoHit;
}

double meets(const Ray& ray, const Solid& solid) {
  return solid.shape == Shape::kCircle ? meets(ray, inside(ray, solid.circle), solid.height)
                                       : meets(ray, inside(ray, solid.box), solid.height);
}

double meets(const Ray& ray, const Segment& wall, double height) {
  const double wall_x = wall.to.x - wall.from.x;
  const double wall_y = wall.to.y - wall.from.y;
  const double x = wall.from.x - ray.from.x;
  const double y = wall.from.y - ray.from.y;
  const double across = ray.x * wall_y - ray.y * wall_x;
  const double length = std::abs(wall_x) + std::abs(wall_y);
  if (std::abs(across) < kNearlyStraight * length) return kNoHit;  // along the wall
  const double range = (x * wall_y - y * wall_x) / across;
  const double part = (x * ray.y - y * ray.x) / across;  // of the wall
  const double tolerance = kCorner / length;
  if (range < 0 || part < -tolerance || part > 1 + tolerance) return kNoHit;
  const double at = ray.height_at(range);
  return at >= 0 && at <= height ? range : kNoHit;
}

double distance(const MapPoint& point, const Segment& segment) {
  const double length_x = segment.to.x - segment.from.x;
  const double length_y = segment.to.y - segment.from.y;
  const double x = point.x - segment.from.x;
  const double y = point.y - segment.from.y;
  const double square = length_x * length_x + length_y * length_y;
  const double part =
      square == 0 ? 0 : std::clamp((x * length_x + y * length_y) / square, 0.0, 1.0);
  return std::hypot(x - part * length_x, y - part * length_y);
}

double distance(const MapPoint& point, const Box& box) {
  const MapPoint local = box.local(point);
  return std::hypot(std::max(std::abs(local.x) - box.half_length, 0.0),
                    std::max(std::abs(local.y) - box.half_width, 0.0));
}

double distance(const MapPoint& point, const Solid& solid) {
  if (solid.shape == Shape::kBox) return distance(point, solid.box);
  return std::max(distance(point, solid.circle.at) - solid.circle.radius, 0.0);
}

bool overlap(const Box& a, const Box& b) {
  return !separates(a, corners(b)) && !separates(b, corners(a));
}

bool overlap(const Box& box, const Segment& segment) {
  if (separates(box, std::array{segment.from, segment.to})) return false;
  // The remaining edge is the segment itself: whether all corners are on one side of it.
  const double x = segment.to.x - segment.from.x;
  const double y = segment.to.y - segment.from.y;
  int left = 0;
  int right = 0;
  for (const MapPoint& corner : corners(box)) {
    const double side = x * (corner.y - segment.from.y) - y * (corner.x - segment.from.x);
    left += side <= 0 ? 1 : 0;
    right += side >= 0 ? 1 : 0;
  }
  return left < 4 && right < 4;
}

bool overlap(const Box& box, const Solid& solid) {
  return solid.shape == Shape::kCircle ? overlap(box, solid.circle) : overlap(box, solid.box);
}

}  // namespace rack::world
