// Makes a map of a building from a recorded drive. Pure.
//
// Four steps: each scan is matched against those before it (keyframes.h); places that were visited
// again are found (loops.h); all scans are matched against all that see the same walls, alternating
// with an optimisation of all poses (Lu and Milios 1997); and cells are classified as free or
// occupied by counting the beams that end in them and that pass through them.
#pragma once

#include "components/localisation/grid_map.h"
#include "components/mapping/loops.h"

namespace rack::mapping {

struct MapSettings {
  double resolution = 50;    // mm
  double range_max = 30000;  // mm: longer beams are not drawn
  int rounds = 3;            // of matching all scans against all others
};

struct MadeMap {
  localisation::GridMap map{};
  std::vector<Pose> poses{};  // of the robot at each scan of the drive
  std::size_t keyframes = 0;
  std::size_t searched = 0;   // keyframes after a jump of the odometry
  std::size_t unmatched = 0;  // keyframes placed by odometry only
  std::size_t loops = 0;      // number of loops found
  std::size_t edges = 0;
  double distance = 0;  // mm
};

// kClosed: stopped by `progress`; kMalformed: the drive has no usable scans.
tims::Result<MadeMap> make_map(const Drive& drive, const MapSettings& settings,
                               const Progress& progress);

}  // namespace rack::mapping
