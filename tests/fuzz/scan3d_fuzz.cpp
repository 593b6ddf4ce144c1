// Compressed points of a 3D scan: any bytes are refused with a reason and change nothing, or yield
// the stated number of points, which are unchanged after compressing and decompressing.
#include <algorithm>

#include "rack/proxies/scan3d_compression.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

bool same(const rack::ScanPoint& a, const rack::ScanPoint& b) {
  return a.x == b.x && a.y == b.y && a.z == b.z && a.type == b.type && a.segment == b.segment &&
         a.intensity == b.intensity;
}

}  // namespace

// Input: number of points (2 bytes), compressed points.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using tims::fuzz::require;
  tims::fuzz::Input input(data, size);
  rack::Scan3dData scan{.pointNum = input.number<rack::u16>()};
  const auto bytes = input.rest();
  scan.compressedPoints.assign(bytes.begin(), bytes.end());
  scan.compressed = static_cast<rack::i32>(bytes.size());
  if (bytes.empty()) return 0;
  rack::Scan3dCompression compression;
  if (const auto read = compression.decompress(scan); !read) {
    require(!read.error().detail().empty() && scan.points.empty() && scan.compressed != 0);
    return 0;
  }
  require(static_cast<rack::i32>(scan.points.size()) == scan.pointNum && scan.compressed == 0);
  rack::Scan3dData again = scan;
  if (!compression.compress(again)) return 0;
  require(again.compressedPoints.size() <= scan.points.size() * 20);
  require(compression.decompress(again).ok());
  require(std::ranges::equal(again.points, scan.points, same));
  return 0;
}
