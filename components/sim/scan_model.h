// What a scanner in the middle of the robot would see of a floor plan (specification, section
// 10.3). Pure.
//
// From the place of the robot a ray is cast into each direction of the scanner, and its way to the
// first wall is the distance that is measured, without noise; a ray that meets none within the
// range of the scanner is invalid, as a real scanner says it.
#pragma once

#include <chrono>
#include <vector>

#include "components/geometry/floor_map.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/odometry.h"
#include "rack/proxies/scan2d.h"

namespace rack::sim {

struct ScanSettings {
  i32 max_range = 10000;  // mm
  i32 first = -180;       // deg, of the robot
  i32 last = 180;
  i32 step = 1;

  [[nodiscard]] i32 count() const { return (last - first) / step + 1; }
};

class ScanModel {
 public:
  // settings: step of 1 and more, last not before first.
  ScanModel(FloorMap map, const ScanSettings& settings);

  void see(const OdometryData& from, std::chrono::milliseconds duration, LadarData& scan);
  void see(const OdometryData& from, std::chrono::milliseconds duration, Scan2dData& scan);

 private:
  void cast(const OdometryData& from);
  [[nodiscard]] double angle(std::size_t ray) const;

  FloorMap map_;
  ScanSettings settings_;
  std::vector<double> ranges_;
};

}  // namespace rack::sim
