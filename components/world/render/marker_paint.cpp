#include "components/world/render/marker_paint.h"

#include <cmath>
#include <memory>
#include <optional>

extern "C" {
#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagStandard41h12.h>
}

namespace rack::world {

namespace {

constexpr int kCellPixels = 16;

struct FamilyName {
  std::string_view name;
  apriltag_family_t* (*make)();
  void (*destroy)(apriltag_family_t*);
};
constexpr FamilyName kFamilies[] = {
    {"tag36h11", tag36h11_create, tag36h11_destroy},
    {"tag25h9", tag25h9_create, tag25h9_destroy},
    {"tag16h5", tag16h5_create, tag16h5_destroy},
    {"tagStandard41h12", tagStandard41h12_create, tagStandard41h12_destroy},
};

// A cell of the marker is a square of pixels, so that its edges are sharp from near.
Texture enlarged(const image_u8_t& cells) {
  const int side = cells.width * kCellPixels;
  std::vector<std::uint32_t> pixels;
  pixels.reserve(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      // Printed: black is not 0, and white not 255.
      const bool is_white = cells.buf[y / kCellPixels * cells.stride + x / kCellPixels] > 127;
      pixels.push_back((is_white ? Colour{240, 240, 238} : Colour{22, 22, 24}).packed());
    }
  return {side, side, std::move(pixels)};
}

}  // namespace

MarkerPaint::MarkerPaint(std::span<const MarkerDescription> markers) {
  for (const MarkerDescription& marker : markers) {
    const Name name{marker.family, marker.id};
    if (pictures_.contains(name)) continue;
    for (const FamilyName& known : kFamilies) {
      if (known.name != marker.family) continue;
      const std::unique_ptr<apriltag_family_t, void (*)(apriltag_family_t*)> family(known.make(),
                                                                                    known.destroy);
      if (marker.id < 0 || static_cast<std::uint32_t>(marker.id) >= family->ncodes) continue;
      const std::unique_ptr<image_u8_t, void (*)(image_u8_t*)> cells(
          apriltag_to_image(family.get(), marker.id), image_u8_destroy);
      pictures_.emplace(name, Picture{enlarged(*cells), static_cast<double>(family->total_width) /
                                                            family->width_at_border});
    }
  }
}

void MarkerPaint::draw(Artist& artist, const MarkerDescription& marker) const {
  const auto found = pictures_.find({marker.family, marker.id});
  if (found == pictures_.end()) return;
  const Picture& picture = found->second;
  const double half = marker.size * picture.whole / 2;
  // Seen from the front, the right is to the right of somebody who looks at it.
  const double right_x = std::sin(marker.rho) * half;
  const double right_y = -std::cos(marker.rho) * half;
  const MapPoint left{marker.at.x - right_x, marker.at.y - right_y};
  const MapPoint right{marker.at.x + right_x, marker.at.y + right_y};
  const double side = picture.texture.levels().front().width;
  // A map says that it is on the wall, to within the width of a hand: it is always in front of it.
  constexpr double kBeforeWall = 60;  // mm
  artist.polygon(std::array{Artist::Spot{Artist::point(left, marker.height + half), 0, 0},
                            Artist::Spot{Artist::point(right, marker.height + half), side, 0},
                            Artist::Spot{Artist::point(right, marker.height - half), side, side},
                            Artist::Spot{Artist::point(left, marker.height - half), 0, side}},
                 1, {.texture = &picture.texture, .nearer = kBeforeWall});
}

}  // namespace rack::world
