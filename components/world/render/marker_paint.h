// The pictures of the markers of a world: AprilTags, drawn by their library.
#pragma once

#include <map>
#include <string>
#include <utility>

#include "components/world/core/description.h"
#include "components/world/render/artist.h"

namespace rack::world {

class MarkerPaint {
 public:
  // Throws nothing; markers that their family does not have are left out.
  explicit MarkerPaint(std::span<const MarkerDescription> markers);
  void draw(Artist& artist, const MarkerDescription& marker) const;

 private:
  struct Picture {
    Texture texture;
    double whole = 1;  // its side, with the white border, for a marker of size 1
  };
  using Name = std::pair<std::string, int>;

  std::map<Name, Picture> pictures_;
};

}  // namespace rack::world
