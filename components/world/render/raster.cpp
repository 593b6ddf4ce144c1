#include "components/world/render/raster.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace rack::world {

namespace {

using Vector = std::array<double, 3>;

constexpr double kNearest = 20;  // mm: nothing before that is drawn
constexpr int kPart = 16;        // pixels of a row that use the same level of a texture

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Inlined by force below: these are executed for every pixel, and a call costs as much as they do.
//
// The channels of a pixel two by two, so that both are multiplied at once.
constexpr std::uint32_t kRedAndBlue = 0x00FF00FFU;
constexpr std::uint32_t kGreen = 0x0000FF00U;

// part: 0 to 256, of b.
std::uint32_t mixed(std::uint32_t a, std::uint32_t b, std::uint32_t part) {
  const std::uint32_t rest = 256 - part;
  return (((a & kRedAndBlue) * rest + (b & kRedAndBlue) * part) >> 8U & kRedAndBlue) |
         (((a & kGreen) * rest + (b & kGreen) * part) >> 8U & kGreen);
}

constexpr std::uint32_t kFullLight = 256;

// light: 256 is 1. Up to that, no channel can overflow.
[[gnu::always_inline]] inline std::uint32_t lit(std::uint32_t pixel, std::uint32_t light) {
  if (light <= kFullLight)
    return 0xFF000000U | ((pixel & kRedAndBlue) * light >> 8U & kRedAndBlue) |
           ((pixel & kGreen) * light >> 8U & kGreen);
  const auto part = [&](std::uint32_t shift) {
    return std::min(255U, ((pixel >> shift & 0xFFU) * light) >> 8U) << shift;
  };
  return 0xFF000000U | part(0) | part(8) | part(16);
}

// std::floor() would be a call of a function. The limits are those of 1/256 pixels in an int:
// beyond, a place is so far away that it does not matter.
int whole(float value) {
  value = std::clamp(value, -1e9F, 1e9F);
  const int part = static_cast<int>(value);
  return part - (static_cast<float>(part) > value ? 1 : 0);
}

std::uint32_t light_of(double light) {
  return static_cast<std::uint32_t>(std::clamp(light, 0.0, 2.0) * 256);
}

// Bilinear. x, y: 256 for each pixel of the level.
[[gnu::always_inline]] inline std::uint32_t sample(const Texture::Level& level, bool repeats, int x,
                                                   int y) {
  int x0 = x >> 8;
  int y0 = y >> 8;
  int x1 = x0 + 1;
  int y1 = y0 + 1;
  if (repeats) {
    x0 &= level.width - 1;
    x1 &= level.width - 1;
    y0 &= level.height - 1;
    y1 &= level.height - 1;
  } else {
    x0 = std::clamp(x0, 0, level.width - 1);
    x1 = std::clamp(x1, 0, level.width - 1);
    y0 = std::clamp(y0, 0, level.height - 1);
    y1 = std::clamp(y1, 0, level.height - 1);
  }
  const auto right = static_cast<std::uint32_t>(x & 0xFF);
  const auto down = static_cast<std::uint32_t>(y & 0xFF);
  const std::uint32_t* const upper = &level.pixels[static_cast<std::size_t>(y0 * level.width)];
  const std::uint32_t* const lower = &level.pixels[static_cast<std::size_t>(y1 * level.width)];
  return mixed(mixed(upper[x0], upper[x1], right), mixed(lower[x0], lower[x1], right), down);
}

}  // namespace

struct Raster::Piece {
  const Texture* texture = nullptr;
  Plane nearness{};  // 1/z
  Plane u{};         // u/z
  Plane v{};
  Plane light{};
  bool is_smooth = false;
  bool is_shadow = false;
  std::uint32_t flat = 256;  // its light, if that is the same everywhere
  float nearer = 0;
};

Raster::Raster(int width, int height, double focal, double cx, double cy)
    : width_(width),
      height_(height),
      focal_(focal),
      cx_(cx),
      cy_(cy),
      pixels_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      nearness_(pixels_.size()) {}

void Raster::clear() {
  std::ranges::fill(pixels_, 0xFF000000U);
  std::ranges::fill(nearness_, 0.0F);
}

// The product with a pixel's ray ((x - cx) / f, (y - cy) / f, 1).
Raster::Plane Raster::plane_of(const Vector& v) const {
  const double a = v[0] / focal_;
  const double b = v[1] / focal_;
  return {a, b, v[2] - a * cx_ - b * cy_};
}

bool Raster::may_see(std::span<const Corner> corners) const {
  // The four sides of what is visible, and the plane of the camera: hidden if all corners are
  // outside of one.
  const std::array<Vector, 5> inner = {{{1, 0, (cx_ + 1) / focal_},
                                        {-1, 0, (width_ - cx_) / focal_},
                                        {0, 1, (cy_ + 1) / focal_},
                                        {0, -1, (height_ - cy_) / focal_},
                                        {0, 0, 1}}};
  return std::ranges::all_of(inner, [&](const Vector& side) {
    return std::ranges::any_of(corners,
                               [&](const Corner& corner) { return dot(corner.at, side) > 0; });
  });
}

// The first row, and the one after the last.
std::array<int, 2> Raster::rows_of(std::span<const Corner> corners) const {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Corner& corner : corners) {
    if (corner.at[2] < kNearest) return {0, height_};
    const double y = cy_ + focal_ * corner.at[1] / corner.at[2];
    low = std::min(low, y);
    high = std::max(high, y);
  }
  const double end = height_;
  return {static_cast<int>(std::clamp(std::ceil(low), 0.0, end)),
          static_cast<int>(std::clamp(std::floor(high) + 1, 0.0, end))};
}

void Raster::draw(std::span<const Corner> corners, const Paint& paint) {
  if (!may_see(corners)) return;
  const std::array<Vector, 3> products = {cross(corners[1].at, corners[2].at),
                                          cross(corners[2].at, corners[0].at),
                                          cross(corners[0].at, corners[1].at)};
  const double volume = dot(corners[0].at, products[0]);
  const bool is_front = volume > 0;
  if (volume == 0 || (!is_front && !paint.both_sides)) return;
  // A value given at three corners, divided by z, is linear.
  const auto spread = [&](const auto& value) {
    Vector sum{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) sum[k] += value(corners[i]) * products[i][k] / volume;
    return plane_of(sum);
  };
  Piece piece{.texture = paint.texture, .is_shadow = paint.is_shadow};
  piece.nearness = spread([](const Corner&) { return 1.0; });
  piece.u = spread([](const Corner& c) { return c.u; });
  piece.v = spread([](const Corner& c) { return c.v; });
  piece.is_smooth = std::ranges::any_of(
      corners, [&](const Corner& c) { return c.light != corners.front().light; });
  if (piece.is_smooth) piece.light = spread([](const Corner& c) { return 256 * c.light; });
  piece.flat = light_of(corners.front().light);
  piece.nearer = static_cast<float>(paint.nearer);

  // Limits of x in a row: edges, and the distance below which nothing is drawn.
  std::array<Plane, 5> sides{};
  std::size_t count = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    Vector side = cross(corners[i].at, corners[(i + 1) % corners.size()].at);
    if (!is_front)
      for (double& part : side) part = -part;
    sides[count++] = plane_of(side);
  }
  const Plane& near = piece.nearness;
  sides[count++] = {-near.a, -near.b, 1 / kNearest - near.c};

  const auto [first, last] = rows_of(corners);
  for (int y = first; y < last; ++y) {
    double from = 0;
    double to = width_;
    for (std::size_t i = 0; i < count; ++i) {
      const Plane& side = sides[i];
      const double rest = side.b * y + side.c;
      if (side.a > 0)
        from = std::max(from, -rest / side.a);
      else if (side.a < 0)
        to = std::min(to, -rest / side.a);
      else if (rest < 0)
        to = from;
    }
    if (from < to)
      draw_row(piece, y, static_cast<int>(std::ceil(from)), static_cast<int>(std::ceil(to)));
  }
}

void Raster::draw_row(const Piece& piece, int y, int from, int to) {
  for (int x = from; x < to; x += kPart) {
    const int end = std::min(to, x + kPart);
    if (piece.is_shadow)
      darken(piece, y, x, end);
    else if (piece.texture->is_plain())
      piece.is_smooth ? fill<true, false>(piece, y, x, end) : fill<false, false>(piece, y, x, end);
    else
      piece.is_smooth ? fill<true, true>(piece, y, x, end) : fill<false, true>(piece, y, x, end);
  }
}

template <bool kSmooth, bool kTextured>
void Raster::fill(const Piece& piece, int y, int from, int to) {
  const auto& levels = piece.texture->levels();
  std::size_t number = 0;
  if (kTextured) {
    // How many pixels of the texture the middle of this part steps over, to the right and down.
    const double x = (from + to - 1) * 0.5;
    const double z = 1 / piece.nearness.at(x, y);
    const double u = piece.u.at(x, y) * z;
    const double v = piece.v.at(x, y) * z;
    const double right = std::pow(piece.u.a - u * piece.nearness.a, 2) +
                         std::pow(piece.v.a - v * piece.nearness.a, 2);
    const double down = std::pow(piece.u.b - u * piece.nearness.b, 2) +
                        std::pow(piece.v.b - v * piece.nearness.b, 2);
    const double square = (right + down) / 2 * z * z;
    if (square > 1)
      number = std::min(levels.size() - 1, static_cast<std::size_t>(std::ilogb(square) + 1) / 2);
  }
  const Texture::Level& level = levels[number];
  const bool repeats = piece.texture->repeats();
  const float scale = 256.0F / static_cast<float>(1U << number);
  const auto start = static_cast<double>(from);
  auto near = static_cast<float>(piece.nearness.at(start, y));
  auto u = static_cast<float>(piece.u.at(start, y)) * scale;
  auto v = static_cast<float>(piece.v.at(start, y)) * scale;
  auto light = static_cast<float>(piece.light.at(start, y));
  const auto near_step = static_cast<float>(piece.nearness.a);
  const auto u_step = static_cast<float>(piece.u.a) * scale;
  const auto v_step = static_cast<float>(piece.v.a) * scale;
  const auto light_step = static_cast<float>(piece.light.a);
  const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
  const std::uint32_t plain = level.pixels.front();
  const std::uint32_t flat = lit(plain, piece.flat);
  for (auto i = row + static_cast<std::size_t>(from); i < row + static_cast<std::size_t>(to); ++i) {
    const float counted = near + piece.nearer * near * near;
    if (counted > nearness_[i]) {
      nearness_[i] = counted;
      std::uint32_t brightness = piece.flat;
      const float z = 1 / near;
      if (kSmooth) brightness = static_cast<std::uint32_t>(std::clamp(light * z, 0.0F, 512.0F));
      if (!kTextured)
        pixels_[i] = kSmooth ? lit(plain, brightness) : flat;
      else
        // The middle of a texture's first pixel is at 0.5.
        pixels_[i] =
            lit(sample(level, repeats, whole(u * z - 128.0F), whole(v * z - 128.0F)), brightness);
    }
    near += near_step;
    if (kTextured) {
      u += u_step;
      v += v_step;
    }
    if (kSmooth) light += light_step;
  }
}

void Raster::darken(const Piece& piece, int y, int from, int to) {
  const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
  for (int x = from; x < to; ++x) {
    const auto near = static_cast<float>(piece.nearness.at(x, y));
    const std::size_t i = row + static_cast<std::size_t>(x);
    if (near + piece.nearer * near * near < nearness_[i]) continue;
    const auto light = piece.is_smooth
                           ? light_of(piece.light.at(x, y) / (256.0 * static_cast<double>(near)))
                           : piece.flat;
    pixels_[i] = lit(pixels_[i], light);
  }
}

}  // namespace rack::world
