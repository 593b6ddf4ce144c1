#include "components/world/render/pixel_noise.h"

#include <algorithm>
#include <cmath>

#include <opencv2/core.hpp>

#include "components/world/core/noise.h"

namespace rack::world {

namespace {
constexpr std::size_t kMore = 1 << 16;  // numbers in the table beyond those of a line
}

PixelNoise::PixelNoise(int line_values, int lines, double deviation, std::uint64_t seed)
    : line_values_(static_cast<std::size_t>(line_values)),
      lines_(static_cast<std::size_t>(lines)),
      seed_(seed) {
  if (deviation <= 0) return;
  Random random(seed);
  for (std::size_t i = 0; i < line_values_ + kMore; ++i) {
    const double value = std::round(deviation * static_cast<double>(random.normal()));
    brighter_.push_back(static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0)));
    darker_.push_back(static_cast<std::uint8_t>(std::clamp(-value, 0.0, 255.0)));
  }
}

// Numbers of 8 bits that stop at 0 and 255 are added and subtracted many at once.
void PixelNoise::add(std::span<std::uint8_t> values, tims::Duration when) const {
  if (brighter_.empty()) return;
  Random random = noise_at(seed_, when);
  const auto line_of = [&](const std::uint8_t* from) {
    return cv::Mat(1, static_cast<int>(line_values_), CV_8UC1, const_cast<std::uint8_t*>(from));
  };
  for (std::size_t line = 0; line < lines_; ++line) {
    const std::size_t begin = random.below(kMore);
    cv::Mat out = line_of(&values[line * line_values_]);
    cv::add(out, line_of(&brighter_[begin]), out);
    cv::subtract(out, line_of(&darker_[begin]), out);
  }
}

}  // namespace rack::world
