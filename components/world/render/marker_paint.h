// The pictures of the markers of a world.
#pragma once

#include <span>
#include <vector>

#include "components/vision/marker_map.h"
#include "components/world/render/artist.h"

namespace rack::world {

class MarkerPaint {
 public:
  // Markers that do not exist, such as a number that their family does not have, are left out.
  explicit MarkerPaint(std::span<const vision::Marker> markers);
  void draw(Artist& artist) const;

 private:
  struct Painted {
    vision::Marker marker;
    Texture texture;
    double half = 0;  // of its side with the white border, mm
  };

  static void draw(Artist& artist, const Painted& painted);

  std::vector<Painted> all_;
};

}  // namespace rack::world
