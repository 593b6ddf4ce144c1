#include "components/world/render/materials.h"

#include <cmath>
#include <utility>

#include "components/geometry/random.h"

namespace rack::world {

namespace {

constexpr int kSide = Materials::kSide;

double hashed(int x, int y, std::uint64_t seed) {
  const auto place = static_cast<std::uint64_t>(y) * 65536U + static_cast<std::uint64_t>(x);
  return static_cast<double>(Random(seed * 7919 + place).uniform());
}

// Stains, 0 to 1: random values at the points of a lattice, and smooth between them. They repeat
// after `side`, a multiple of `size`.
double stain(int x, int y, int size, int side, std::uint64_t seed) {
  const int count = side / size;
  const auto value = [&](int column, int row) { return hashed(column % count, row % count, seed); };
  const auto smooth = [](double part) { return part * part * (3 - 2 * part); };
  const int column = x / size;
  const int row = y / size;
  const double right = smooth(static_cast<double>(x % size) / size);
  const double down = smooth(static_cast<double>(y % size) / size);
  const double upper = value(column, row) * (1 - right) + value(column + 1, row) * right;
  const double lower = value(column, row + 1) * (1 - right) + value(column + 1, row + 1) * right;
  return upper * (1 - down) + lower * down;
}

// Brighter and darker by this share: large and small stains, and grains.
double uneven(int x, int y, int side, std::uint64_t seed, double share) {
  return 1 + share * (stain(x, y, 64, side, seed) + 0.7 * stain(x, y, 16, side, seed + 1) +
                      0.5 * hashed(x, y, seed + 2) - 1.1);
}

template <typename ColourAt>
Texture painted(int side, const ColourAt& colour_at) {
  std::vector<std::uint32_t> pixels;
  pixels.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) pixels.push_back(colour_at(x, y).packed());
  return {side, side, std::move(pixels)};
}

// Of 320 x 80 mm, each row shifted by half a brick.
Colour brick(int x, int y, const Colour& colour, std::uint64_t seed) {
  constexpr int kLength = 32;
  constexpr int kHeight = 8;
  const int row = y / kHeight;
  const int shifted = (x + (row % 2) * kLength / 2) % kSide;
  if (y % kHeight == 0 || shifted % kLength == 0)
    return Colour{168, 164, 156}.times(uneven(x, y, kSide, seed, 0.1));
  const double own = 0.82 + 0.36 * hashed(shifted / kLength, row, seed + 9);
  return colour.times(own * uneven(x, y, kSide, seed, 0.12));
}

// A skirting board, bricks up to a rail at the height of a hand, and plaster with seams above.
Texture inner_wall(const Colour& plaster, const Colour& bricks, std::uint64_t seed) {
  return painted(kSide, [&](int x, int y) {
    constexpr int kBoard = 10;
    constexpr int kBricks = 96;
    constexpr int kRail = 104;
    constexpr int kPanel = 128;
    if (y < kBoard) return Colour{74, 62, 54}.times(uneven(x, y, kSide, seed, 0.15));
    if (y < kBricks) return brick(x, y, bricks, seed);
    if (y < kRail) return Colour{116, 92, 66}.times(uneven(x, y, kSide, seed, 0.15));
    const double seam = x % kPanel < 2 ? 0.78 : 1;
    return plaster.times(seam * uneven(x, y, kSide, seed + 5, 0.14));
  });
}

Texture outer_wall(const Colour& bricks, std::uint64_t seed) {
  return painted(kSide, [&](int x, int y) { return brick(x, y, bricks, seed); });
}

// Square tiles of 640 mm.
Texture tiles() {
  return painted(kSide, [](int x, int y) {
    constexpr int kTile = 32;
    if (x % kTile == 0 || y % kTile == 0) return Colour{88, 86, 82};
    const double own = 0.92 + 0.16 * hashed(x / kTile, y / kTile, 31);
    return Colour{146, 140, 130}.times(own * uneven(x, y, kSide, 32, 0.16));
  });
}

Texture asphalt() {
  return painted(kSide, [](int x, int y) {
    return Colour{106, 106, 108}.times(uneven(x, y, kSide, 41, 0.4));
  });
}

// Panels of 640 mm, one in sixteen is a lamp.
Texture panels() {
  return painted(kSide, [](int x, int y) {
    constexpr int kPanel = 32;
    if (x % kPanel == 0 || y % kPanel == 0) return Colour{140, 140, 140};
    if (x / kPanel % 4 == 1 && y / kPanel % 4 == 1) return Colour{255, 255, 250};
    return Colour{205, 205, 200}.times(uneven(x, y, kSide, 51, 0.08));
  });
}

Texture planks() {
  constexpr int kSideOfCrate = Materials::kCrateSide;
  return painted(kSideOfCrate, [](int x, int y) {
    constexpr int kFrame = 7;
    const bool is_frame = x < kFrame || y < kFrame || x >= kSideOfCrate - kFrame ||
                          y >= kSideOfCrate - kFrame || std::abs(x - y) < 4;
    const double grain = uneven(x, y / 4 * 4, kSideOfCrate, 61, 0.25);
    if (is_frame) return Colour{172, 128, 78}.times(grain);
    return Colour{148, 106, 62}.times(grain * (y % 10 == 0 ? 0.6 : 1));
  });
}

Texture rings() {
  constexpr int kSideOfBarrel = 64;
  return painted(kSideOfBarrel, [](int x, int y) {
    const double ring = y % 20 < 3 ? 0.65 : 1;
    return Colour{70, 104, 92}.times(ring * uneven(x, y, kSideOfBarrel, 71, 0.15));
  });
}

Texture hull() {
  constexpr int kSideOfHull = 64;
  return painted(kSideOfHull, [](int x, int y) {
    if (y > 22 && y < 32) return Colour{30, 30, 34};
    return Colour{196, 60, 40}.times(uneven(x, y, kSideOfHull, 81, 0.1));
  });
}

}  // namespace

Materials::Materials(bool is_indoors)
    : walls(is_indoors ? std::array{inner_wall({222, 214, 192}, {150, 88, 70}, 1),
                                    inner_wall({190, 206, 214}, {126, 104, 92}, 2),
                                    inner_wall({202, 212, 186}, {158, 116, 84}, 3)}
                       : std::array{outer_wall({156, 92, 74}, 4), outer_wall({170, 150, 126}, 5),
                                    outer_wall({134, 124, 118}, 6)}),
      ground(is_indoors ? tiles() : asphalt()),
      ceiling(panels()),
      crate(planks()),
      barrel(rings()),
      robot(hull()),
      wheel(Colour{36, 36, 38}),
      sky(Colour{150, 186, 226}) {}

}  // namespace rack::world
