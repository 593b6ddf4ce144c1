// Draws textured polygons as a pinhole sees them, with a depth buffer: what is nearer hides what is
// farther away, in any order. Drawing near objects first is faster.
//
// A polygon needs no clipping (Olano and Greer 1997): a pixel looks along the ray (x, y, 1), and is
// inside if the ray is on the inner side of the plane through the camera and each edge. These are
// linear functions of x and y, as are 1/z, u/z and v/z on a plane; of each row they give the first
// and the last pixel, also for polygons that reach behind the camera.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "components/world/render/texture.h"

namespace rack::world {

// In the frame of the camera, mm: x right, y down, z ahead.
struct Corner {
  std::array<double, 3> at{};
  double u = 0;  // pixels of the texture
  double v = 0;
  double light = 1;  // brightness, 0 to 2
};

struct Paint {
  const Texture* texture = nullptr;
  bool both_sides = false;
  bool is_shadow = false;  // darkens what is there by `light`, and hides nothing
  double nearer = 0;       // mm: how much nearer it counts, for pictures on a wall
};

class Raster {
 public:
  // The principal point is (cx, cy), in pixels from the middle of the first one.
  Raster(int width, int height, double focal, double cx, double cy);

  void clear();
  // A convex polygon of 3 or 4 corners in a plane, clockwise when seen from its front. u, v and
  // light follow from the first three.
  void draw(std::span<const Corner> corners, const Paint& paint);
  // Whether something between these corners may be visible.
  [[nodiscard]] bool may_see(std::span<const Corner> corners) const;

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  // Row by row, as Colour::packed().
  [[nodiscard]] std::span<std::uint32_t> pixels() { return pixels_; }

 private:
  // a x + b y + c, of a pixel.
  struct Plane {
    double a = 0;
    double b = 0;
    double c = 0;
    [[nodiscard]] double at(double x, double y) const { return a * x + b * y + c; }
  };
  struct Piece;

  [[nodiscard]] Plane plane_of(const std::array<double, 3>& v) const;
  [[nodiscard]] std::array<int, 2> rows_of(std::span<const Corner> corners) const;
  void draw_row(const Piece& piece, int y, int from, int to);
  template <bool kSmooth, bool kTextured>
  void fill(const Piece& piece, int y, int from, int to);
  void darken(const Piece& piece, int y, int from, int to);

  int width_;
  int height_;
  double focal_;
  double cx_;
  double cy_;
  std::vector<std::uint32_t> pixels_;
  std::vector<float> nearness_;  // 1/z of what is there, 1/mm
};

}  // namespace rack::world
