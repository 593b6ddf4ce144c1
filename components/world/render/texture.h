// A picture on a surface, with all its reductions by powers of two (a mip map, Williams 1983): a
// surface that is far away is painted with a small one, so that fine patterns become their mean
// instead of flickering.
#pragma once

#include <cstdint>
#include <vector>

#include "components/world/render/colour.h"

namespace rack::world {

class Texture {
 public:
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<std::uint32_t> pixels{};  // as Colour::packed()
  };

  // One colour.
  explicit Texture(const Colour& colour);
  // `pixels`: row by row. Sides that are powers of two repeat it, others extend its border.
  Texture(int width, int height, std::vector<std::uint32_t> pixels);

  [[nodiscard]] const std::vector<Level>& levels() const { return levels_; }
  [[nodiscard]] bool repeats() const { return repeats_; }
  [[nodiscard]] bool is_plain() const { return levels_.front().pixels.size() == 1; }

 private:
  std::vector<Level> levels_;
  bool repeats_ = true;
};

}  // namespace rack::world
