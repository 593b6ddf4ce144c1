// The noise of a camera's pixels: a table of random numbers, of which each line of each picture
// takes another part. It follows from the seed and the time of the picture.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tims/time.h"

namespace rack::world {

class PixelNoise {
 public:
  // `deviation`: standard deviation, in 1/255 of the full brightness; 0: none.
  PixelNoise(int line_values, int lines, double deviation, std::uint64_t seed);
  void add(std::span<std::uint8_t> values, tims::Duration when) const;

 private:
  std::size_t line_values_;
  std::size_t lines_;
  std::uint64_t seed_;
  std::vector<std::uint8_t> brighter_;
  std::vector<std::uint8_t> darker_;
};

}  // namespace rack::world
