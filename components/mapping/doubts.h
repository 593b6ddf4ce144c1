// Where a map contradicts itself: scans see through walls that scans of another pass drew there.
// Pure.
//
// With correct poses this happens at doors that have moved and where people stood, for a few
// points. Where two corridors are drawn over each other, or one corridor twice, a large share of
// the points of a scan is contradicted.
#pragma once

#include <vector>

#include "components/geometry/floor_map.h"
#include "components/mapping/keyframes.h"

namespace rack::mapping {

struct Doubts {
  double compared = 0;             // mm of travel along which there was another pass
  double distance = 0;             // mm of travel that is contradicted
  std::vector<MapPoint> places{};  // of the robot there
  std::vector<MapPoint> walls{};   // that were seen through from there, or that it saw through
};

// Nothing: stopped by `progress`.
std::optional<Doubts> find_doubts(const Track& track, const Progress& progress);

}  // namespace rack::mapping
