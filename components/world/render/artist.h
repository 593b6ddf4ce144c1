// Draws bodies of the world into a raster: boxes, cylinders, tubes, spheres. Points are those of
// the world: north, east, down, in mm.
#pragma once

#include <array>
#include <span>

#include "components/world/core/shapes.h"
#include "components/world/core/view.h"
#include "components/world/render/raster.h"

namespace rack::world {

using Point3 = std::array<double, 3>;

// A cross-section of a tube: an ellipse at this share of its length.
struct Ring {
  double at = 0;       // 0: lower end, 1: upper end
  double forward = 0;  // radii, mm
  double side = 0;
};

class Artist {
 public:
  // Both must outlive the artist.
  Artist(Raster& raster, const View& view) : raster_(raster), view_(view) {}

  // Height above the ground.
  static Point3 point(const MapPoint& at, double height) { return {at.x, at.y, -height}; }

  struct Spot {
    Point3 at{};
    double u = 0;
    double v = 0;
    double light = 1;  // share of that of the polygon
  };
  void polygon(std::span<const Spot> spots, double light, const Paint& paint);
  // A box on the ground, between two heights. Each side shows the whole texture.
  void box(const Box& box, double low, double high, const Texture& texture);
  void cylinder(const MapPoint& at, double radius, double height, const Texture& texture);
  // From `low` to `high`; `forward`: direction in which its rings are measured. Smooth.
  void tube(const Point3& low, const Point3& high, const Point3& forward,
            std::span<const Ring> rings, const Texture& texture);
  void ellipsoid(const Point3& middle, const Point3& forward, const Ring& radii, double height,
                 const Texture& texture);
  // On the ground.
  void shadow(const MapPoint& at, double rho, double half_length, double half_width);

  // Light on a surface with this normal, which need not have the length 1.
  static double light(const Point3& normal);
  // Distance over ground from the camera.
  [[nodiscard]] double distance_to(const MapPoint& at) const;

 private:
  [[nodiscard]] std::array<double, 3> seen(const Point3& at) const;
  [[nodiscard]] int sides_at(double distance) const;

  Raster& raster_;
  const View& view_;
};

}  // namespace rack::world
