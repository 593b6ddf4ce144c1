// The compressed form of a scan of space, as the original's library makes and its graphical
// interface reads it (specification, section 13). Nothing is lost.
//
// Neighbours in a scan are near to each other: of x, y and z only the way from point to point is
// kept, a byte where it is short; types and segments become a value and how often it follows, and
// intensities take as many bytes as they need (stage 1, method 5). Stage 2 does nothing. Stage 3
// is a Huffman code over these bytes: frequent ones get few bits. Its tree is made on both sides of
// the counts that come first: again and again the two rarest nodes are joined.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "rack/proxies/scan3d.h"
#include "tims/result.h"

#pragma GCC visibility push(default)  // what librack.so shows
namespace rack {

// Keeps its memory: scans of the same size allocate once. Scans with reserve_all() never do.
class Scan3dCompression {
 public:
  // The points become compressed ones. False: they would not be smaller, or there are none; all
  // stays as it is.
  bool compress(Scan3dData& scan);
  // The compressed points become points; others stay as they are. Understands methods 0 and 5, with
  // Huffman or without. kMalformed says what is wrong; what was in the scan then is not changed.
  tims::Result<void> decompress(Scan3dData& scan);

 private:
  std::vector<std::byte> stages_;  // 1 and 2
  std::vector<ScanPoint> points_;
};

}  // namespace rack

#pragma GCC visibility pop
