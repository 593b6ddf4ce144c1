// JPEG by OpenCV: decoding and encoding.
//
// OpenCV allocates memory for each picture that it decodes or encodes. A picture whose compressed
// pixels are damaged is decoded up to the damage: OpenCV does not report it, and libjpeg below it
// writes a line to the standard error. What can be found without decoding is refused (check_jpeg).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "components/pictures/jpeg_frame.h"
#include "components/pictures/pixels.h"
#include "tims/result.h"

namespace rack::pictures {

// Not thread-safe. Invalid pictures cause an error only.
class Jpeg {
 public:
  Jpeg();

  // To kGrey or kBgr. Resizes `pixels` as required; fails if that exceeds `bytes_max`.
  tims::Result<PictureSize> decode(std::span<const std::byte> jpeg, PixelLayout layout,
                                   std::size_t bytes_max, std::vector<std::byte>& pixels);
  // quality: 1 to 100.
  tims::Result<void> encode(const PixelView& picture, int quality, std::size_t bytes_max,
                            std::vector<std::byte>& jpeg);
  // complete_jpeg() with the standard tables.
  bool complete(std::span<const std::byte> frame, std::vector<std::byte>& jpeg) const {
    return complete_jpeg(frame, tables_, jpeg);
  }

 private:
  PixelConverter converter_;
  std::vector<std::byte> bgr_;
  std::vector<unsigned char> encoded_;
  std::vector<int> settings_;
  std::vector<std::byte> tables_;  // segments with the standard Huffman tables
};

}  // namespace rack::pictures
