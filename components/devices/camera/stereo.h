// Depth from side-by-side pictures of a stereo camera (left one first), by OpenCV. Both must be
// rectified, which such cameras do.
//
// Block matching (StereoBM) compares the block around each point of the left picture with the same
// line of the right one. A match that is not unique, or not confirmed by matching from right to
// left, is discarded, and so is a block without texture: a bare wall is not known. It needs a tenth
// of the time of semi-global matching (StereoSGBM; H. Hirschmueller, "Stereo processing by
// semiglobal matching and mutual information", 2008), which prefers depths that change little: it
// follows edges better and fills bare areas with the depth of their neighbourhood, which is a guess
// when a robot has to avoid them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "tims/result.h"

namespace rack::device {

enum class StereoMethod : std::uint8_t { kBlock, kSemiGlobal };

struct StereoSettings {
  int disparities = 64;  // search range, pixels; rounded up to a multiple of 16
  int block = 9;         // side of the block, pixels, odd, at least 5
  int texture_min = 4;   // minimum mean gradient in a block; rejects bare walls (kBlock)
  int unique = 10;       // %, minimum difference between the best and the second best cost
  StereoMethod method = StereoMethod::kBlock;
};

// OpenCV allocates memory for each pair.
class Stereo {
 public:
  explicit Stereo(const StereoSettings& settings);
  Stereo(const Stereo&) = delete;
  Stereo& operator=(const Stereo&) = delete;
  ~Stereo();

  // `pair`: lines of 2 * width grey pixels. Returns width * height disparities in 1/16 pixel; 0:
  // unknown. They are valid until the next call.
  tims::Result<std::span<const std::uint16_t>> match(std::span<const std::byte> pair, int width,
                                                     int height);
  // scale / disparity for each of the last match, rounded, at most 65535; 0: unknown.
  tims::Result<std::span<const std::uint16_t>> ranges(double scale);

 private:
  struct Matcher;

  StereoSettings settings_;
  std::unique_ptr<Matcher> matcher_;
};

}  // namespace rack::device
