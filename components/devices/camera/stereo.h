// Depth of two pictures side by side, as stereo cameras send them (left eye first): for each point
// of the left one the block of the right one that is most like it, on the same line. Both must be
// rectified, which such cameras do.
//
// Sums of absolute differences, kept line by line, so that a pixel costs the same for every size
// of the block; what is not clearly the best, or not the best also from right to left, is left out.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace rack::device {

struct StereoSettings {
  int disparities = 64;  // how far to look, pixels
  int block = 9;         // side, pixels, odd
  int texture_min = 4;   // mean difference of neighbours in a block: less is a bare wall
  int unique = 10;       // %, that the second best must be worse by
};

class Stereo {
 public:
  explicit Stereo(const StereoSettings& settings) : settings_(settings) {}

  // `pair`: lines of 2 * width grey pixels. In sixteenths of a pixel, width * height; 0: not known.
  std::span<const std::uint16_t> match(std::span<const std::byte> pair, int width, int height);

 private:
  void add_line(std::span<const std::byte> pair, int width, int y, int sign);
  void match_line(int width, std::uint16_t* out);

  StereoSettings settings_;
  std::vector<std::uint16_t> columns_;   // [x][d]: over the lines of a block
  std::vector<std::uint16_t> textures_;  // [x]: the same, of neighbours
  std::vector<std::uint32_t> costs_;     // [x][d]: over the block
  std::vector<std::uint16_t> disparities_;
};

}  // namespace rack::device
