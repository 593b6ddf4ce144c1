// A colour of a surface.
#pragma once

#include <algorithm>
#include <cstdint>

namespace rack::world {

struct Colour {
  double red = 0;  // 0 to 255
  double green = 0;
  double blue = 0;

  // Blue in the lowest byte: in memory B, G, R, 255, as OpenCV's CV_8UC4.
  [[nodiscard]] std::uint32_t packed() const {
    const auto part = [](double value) {
      return static_cast<std::uint32_t>(std::clamp(value, 0.0, 255.0) + 0.5);
    };
    return 0xFF000000U | part(red) << 16U | part(green) << 8U | part(blue);
  }
  [[nodiscard]] Colour times(double factor) const {
    return {red * factor, green * factor, blue * factor};
  }
};

}  // namespace rack::world
