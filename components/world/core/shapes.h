// Circles and boxes on the ground, and rays through them: where a ray enters and leaves, and
// whether two of them overlap (of boxes by the separating axis: two convex figures are apart when
// they are apart along the direction of some edge).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "components/geometry/floor_map.h"
#include "components/world/core/description.h"

namespace rack::world {

inline constexpr double kNoHit = std::numeric_limits<double>::infinity();

// From a point above the ground; along it everything is told by the way over ground.
struct Ray {
  MapPoint from{};
  double x = 1;  // its direction over ground, of length 1
  double y = 0;
  double height = 0;  // above the ground where it begins
  double climb = 0;   // for each mm over ground
  double reach = 0;   // mm over ground

  [[nodiscard]] double height_at(double way) const { return height + climb * way; }
};

struct Circle {
  MapPoint at{};
  double radius = 0;
};

struct Box {
  MapPoint at{};  // its middle
  double c = 1;   // cosine and sine of where its length points to
  double s = 0;
  double half_length = 0;
  double half_width = 0;

  static Box of(const MapPoint& at, double rho, double length, double width) {
    return {at, std::cos(rho), std::sin(rho), length / 2, width / 2};
  }
  // In its own frame.
  [[nodiscard]] MapPoint local(const MapPoint& p) const {
    const double x = p.x - at.x;
    const double y = p.y - at.y;
    return {x * c + y * s, y * c - x * s};
  }
  [[nodiscard]] double radius() const { return std::hypot(half_length, half_width); }
};

struct Segment {
  MapPoint from{};
  MapPoint to{};
};

// An obstacle as one of the two.
struct Solid {
  Shape shape = Shape::kCircle;
  Circle circle{};
  Box box{};
  double height = 0;

  static Solid of(const ObstacleDescription& obstacle);
};

// --- where a ray is inside, as ways over ground; from > to: nowhere

struct Inside {
  double from = kNoHit;
  double to = -kNoHit;
};

Inside inside(const Ray& ray, const Circle& circle);
Inside inside(const Ray& ray, const Box& box);

// The way to the side or the top of a solid of this height, or kNoHit.
double meets(const Ray& ray, const Inside& inside, double height);
double meets(const Ray& ray, const Solid& solid);
// To a wall.
double meets(const Ray& ray, const Segment& wall, double height);

// --- what is apart

double distance(const MapPoint& point, const Segment& segment);
double distance(const MapPoint& point, const Box& box);  // 0 inside
// How far a point is from a solid; 0 inside.
double distance(const MapPoint& point, const Solid& solid);

bool overlap(const Box& a, const Box& b);
bool overlap(const Box& box, const Segment& segment);
inline bool overlap(const Box& box, const Circle& circle) {
  return distance(circle.at, box) < circle.radius;
}
bool overlap(const Box& box, const Solid& solid);

}  // namespace rack::world
