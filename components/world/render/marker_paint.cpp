#include "components/world/render/marker_paint.h"

#include <cmath>
#include <utility>

#include "components/vision/marker_picture.h"

namespace rack::world {

namespace {

// A cell of the marker is a square of pixels, so that its edges are sharp from near.
Texture enlarged(const vision::MarkerPicture& picture) {
  constexpr int kCellPixels = 16;
  // Printed: black is not 0, and white not 255.
  const std::uint32_t white = Colour{240, 240, 238}.packed();
  const std::uint32_t black = Colour{22, 22, 24}.packed();
  const int side = picture.side * kCellPixels;
  std::vector<std::uint32_t> pixels;
  pixels.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const int cell = y / kCellPixels * picture.side + x / kCellPixels;
      constexpr std::uint8_t kGrey = 127;
      pixels.push_back(picture.cells[static_cast<std::size_t>(cell)] > kGrey ? white : black);
    }
  return {side, side, std::move(pixels)};
}

}  // namespace

MarkerPaint::MarkerPaint(std::span<const vision::Marker> markers) {
  for (const vision::Marker& marker : markers) {
    const auto picture = vision::picture_of(marker);
    if (picture) all_.push_back({marker, enlarged(*picture), marker.size * picture->whole / 2});
  }
}

void MarkerPaint::draw(Artist& artist) const {
  for (const Painted& painted : all_) draw(artist, painted);
}

void MarkerPaint::draw(Artist& artist, const Painted& painted) {
  const vision::Marker& marker = painted.marker;
  // The right of somebody who looks at it.
  const double right_x = std::sin(marker.rho) * painted.half;
  const double right_y = -std::cos(marker.rho) * painted.half;
  const MapPoint left{marker.at.x - right_x, marker.at.y - right_y};
  const MapPoint right{marker.at.x + right_x, marker.at.y + right_y};
  const double top = marker.height + painted.half;
  const double bottom = marker.height - painted.half;
  const double side = painted.texture.levels().front().width;
  // A map says that it is on the wall to within some centimetres: it is drawn before the wall.
  constexpr double kBeforeWall = 60;  // mm
  artist.polygon(std::array{Artist::Spot{Artist::point(left, top), 0, 0},
                            Artist::Spot{Artist::point(right, top), side, 0},
                            Artist::Spot{Artist::point(right, bottom), side, side},
                            Artist::Spot{Artist::point(left, bottom), 0, side}},
                 1, {.texture = &painted.texture, .nearer = kBeforeWall});
}

}  // namespace rack::world
