#include "components/scan3d/range_image.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace rack::scan3d {
namespace {

i16 whole(double value) {
  return static_cast<i16>(std::min<double>(value, std::numeric_limits<i16>::max()));
}

RangePixel pixel_of(const ScanPoint& point) {
  const double range = std::hypot(point.x.raw(), point.y.raw(), point.z.raw());
  return {.range = whole(range), .type = static_cast<i16>(point.type)};
}

}  // namespace

Scan3dRangeImageData range_image(const Scan3dData& scan) {
  constexpr i32 kMost = std::numeric_limits<i16>::max();
  const i32 columns = std::clamp(scan.scanPointNum, 0, kMost);
  const i32 rows_max = columns > 0 ? static_cast<i32>(kScan3dPointsMax) / columns : 0;
  const i32 rows = std::clamp(scan.scanNum, 0, std::min(rows_max, kMost));
  Scan3dRangeImageData image{.recordingTime = scan.recordingTime,
                             .scanMode = scan.scanMode,
                             .maxRange = scan.maxRange,
                             .scanNum = static_cast<i16>(rows),
                             .scanPointNum = static_cast<i16>(columns)};
  const bool is_mirrored = (scan.scanMode & 0xFF) == scan_mode::kPitch;
  image.points.reserve(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
  for (i32 row = 0; row < rows; ++row)
    for (i32 column = 0; column < columns; ++column) {
      const i32 in_row = is_mirrored ? columns - 1 - column : column;
      const auto at = static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                      static_cast<std::size_t>(in_row);
      image.points.push_back(at < scan.points.size() ? pixel_of(scan.points[at])
                                                     : RangePixel{.type = scan_point::kInvalid});
    }
  return image;
}

std::string point_lines(const Scan3dData& scan) {
  std::string text;
  for (const ScanPoint& point : scan.points) {
    for (const i32 number :
         {point.x.raw(), point.y.raw(), point.z.raw(), point.type, static_cast<i32>(point.segment)})
      text.append(std::to_string(number)).push_back(' ');
    text.append(std::to_string(point.intensity)).push_back('\n');
  }
  return text;
}

}  // namespace rack::scan3d
