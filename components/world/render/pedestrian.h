// The picture of a person: head, trunk, arms and legs in the proportions of an adult, in clothes of
// their own, walking with the legs that scanners see (core/people.h).
#pragma once

#include <cstddef>
#include <vector>

#include "components/world/render/artist.h"

namespace rack::world {

class Pedestrians {
 public:
  Pedestrians();
  // `height`: of the person, mm.
  void draw(Artist& artist, std::size_t id, const Figure& person, double height) const;

 private:
  std::vector<Texture> skins_;
  std::vector<Texture> hairs_;
  std::vector<Texture> shirts_;
  std::vector<Texture> trousers_;
  Texture shoe_;
};

}  // namespace rack::world
