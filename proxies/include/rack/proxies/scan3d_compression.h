// Lossless compressed form of a three-dimensional scan, compatible with the original library and
// its graphical interface (specification, section 13).
//
// Stage 1 (method 5) uses that neighbouring points are close to each other: x, y and z are stored
// as differences from point to point, in one byte where they are small; types and segments are
// run-length coded; intensities use as many bytes as they need. Stage 2 does nothing. Stage 3 is a
// Huffman code over these bytes. Both sides build its tree from the symbol counts, which are sent
// first: the two rarest nodes are joined repeatedly.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rack/proxies/scan3d.h"
#include "tims/result.h"

#pragma GCC visibility push(default)  // exported by librack.so
namespace rack {

// Keeps its memory: scans of the same size allocate only once, and scans after reserve_all() never.
class Scan3dCompression {
 public:
  // Replaces the points by compressed ones. False: they would not be smaller, or there are no
  // points; the scan is unchanged.
  bool compress(Scan3dData& scan);
  // Replaces the compressed points by points; an uncompressed scan is unchanged. Supports methods 0
  // and 5, with and without Huffman. kMalformed states the problem; the scan is then unchanged.
  tims::Result<void> decompress(Scan3dData& scan);

 private:
  std::vector<std::byte> stages_;  // output of stages 1 and 2
  std::vector<ScanPoint> points_;
};

}  // namespace rack

#pragma GCC visibility pop
