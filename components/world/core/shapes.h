// Circles and boxes on the ground, and rays through them: the entry and exit of a ray, and overlap
// of two shapes (for boxes by the separating axis theorem: two convex shapes are disjoint when they
// are separated along the direction of some edge).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "components/geometry/floor_map.h"
#include "components/world/core/description.h"

namespace rack::world {

inline constexpr double kNoHit = std::numeric_limits<double>::infinity();

// A ray from a point above the ground; positions on it are given by the distance over ground.
struct Ray {
  MapPoint from{};
  double x = 1;  // its direction over ground, unit vector
  double y = 0;
  double height = 0;  // of its start above the ground
  double climb = 0;   // mm per mm over ground
  double reach = 0;   // mm over ground

  [[nodiscard]] double height_at(double distance) const { return height + climb * distance; }
};

struct Circle {
  MapPoint at{};
  double radius = 0;
};

struct Box {
  MapPoint at{};  // its centre
  double c = 1;   // cosine and sine of the direction of its length
  double s = 0;
  double half_length = 0;
  double half_width = 0;

  static Box of(const MapPoint& at, double rho, double length, double width) {
    return {at, std::cos(rho), std::sin(rho), length / 2, width / 2};
  }
  // The point in the frame of the box.
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

// An obstacle as a circle or a box.
struct Solid {
  Shape shape = Shape::kCircle;
  Circle circle{};
  Box box{};
  double height = 0;

  static Solid of(const ObstacleDescription& obstacle);
};

// --- the part of a ray inside a shape, as distances over ground; from > to: none

struct Inside {
  double from = kNoHit;
  double to = -kNoHit;
};

Inside inside(const Ray& ray, const Circle& circle);
Inside inside(const Ray& ray, const Box& box);

// The distance to the side or the top of a solid of this height, or kNoHit.
double meets(const Ray& ray, const Inside& inside, double height);
double meets(const Ray& ray, const Solid& solid);
// The distance to a wall.
double meets(const Ray& ray, const Segment& wall, double height);

// --- distances and overlap

double distance(const MapPoint& point, const Segment& segment);
double distance(const MapPoint& point, const Box& box);  // 0 inside
// Distance of a point to a solid; 0 inside.
double distance(const MapPoint& point, const Solid& solid);

bool overlap(const Box& a, const Box& b);
bool overlap(const Box& box, const Segment& segment);
inline bool overlap(const Box& box, const Circle& circle) {
  return distance(circle.at, box) < circle.radius;
}
bool overlap(const Box& box, const Solid& solid);

}  // namespace rack::world
