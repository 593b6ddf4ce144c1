// Depth from side-by-side pictures of a stereo camera (left one first): block matching of each
// point of the left picture with the same line of the right one. Both must be rectified, which such
// cameras do.
//
// The cost is the sum of absolute differences, updated line by line, so that the time per pixel
// does not depend on the size of the block. Matches that are not unique, or not confirmed by
// matching from right to left, are discarded.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace rack::device {

struct StereoSettings {
  int disparities = 64;  // search range, pixels
  int block = 9;         // side of the block, pixels, odd
  int texture_min = 4;   // minimum mean difference of neighbours in a block; rejects bare walls
  int unique = 10;       // %, minimum difference between the best and the second best cost
};

class Stereo {
 public:
  explicit Stereo(const StereoSettings& settings) : settings_(settings) {}

  // `pair`: lines of 2 * width grey pixels. Returns width * height disparities in 1/16 pixel; 0:
  // unknown.
  std::span<const std::uint16_t> match(std::span<const std::byte> pair, int width, int height);

 private:
  void add_line(std::span<const std::byte> pair, int width, int y, int sign);
  void match_line(int width, std::uint16_t* out);

  StereoSettings settings_;
  std::vector<std::uint16_t> columns_;   // [x][d]: sums over the lines of a block
  std::vector<std::uint16_t> textures_;  // [x]: the same for differences of neighbours
  std::vector<std::uint32_t> costs_;     // [x][d]: sums over the block
  std::vector<std::uint16_t> disparities_;
};

}  // namespace rack::device
