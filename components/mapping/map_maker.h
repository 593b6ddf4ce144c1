// Makes a map of a building from a recorded drive. Pure.
//
// Six steps: each scan is matched against those before it (keyframes.h), first to calibrate the
// odometry (calibration.h), then to find what moves (moving.h), and a third time without it; places
// that were visited again are found (loops.h); all scans are matched against all that see the same
// walls, alternating with an optimisation of all poses (Lu and Milios 1997); the scans are searched
// for walls that other scans see through (doubts.h); the error that the measurements leave possible
// is estimated (pose_graph.h); and cells are classified as free or occupied by counting the beams
// that end in them and that pass through them.
#pragma once

#include "components/localisation/grid_map.h"
#include "components/mapping/doubts.h"
#include "components/mapping/loops.h"

namespace rack::mapping {

struct MapSettings {
  double resolution = 50;    // mm
  double range_max = 30000;  // mm: longer beams are not drawn
  int rounds = 3;            // of matching all scans against all others
};

// The longest part of a drive from one loop to the next.
struct WithoutLoop {
  double distance = 0;  // mm of travel
  MapPoint begin{};
  MapPoint end{};
};

struct MadeMap {
  localisation::GridMap map{};
  std::vector<Pose> poses{};  // of the robot at each scan of the drive
  std::size_t keyframes = 0;
  std::size_t searched = 0;   // keyframes after a jump of the odometry
  std::size_t unmatched = 0;  // keyframes placed by odometry only
  std::size_t loops = 0;      // number of loops found
  std::size_t removed = 0;    // number of loops that others contradicted
  std::size_t edges = 0;
  double distance = 0;  // mm
  Doubts doubts{};
  WithoutLoop without_loop{};
  double uncertain = 0;  // mm: the error that the measurements leave possible, mean over keyframes
};

// The number of cells that the map will have, by the odometry, which is known before the work.
double expected_cells(const Drive& drive, const MapSettings& settings);

// kClosed: stopped by `progress`; kMalformed: the drive has no usable scans. kTooBig: more than
// Occupancy::kCellsMax cells; reported before the work when the odometry expects twice as many.
// When the map turns out to be larger than that after the work, its cells become up to twice as
// large.
tims::Result<MadeMap> make_map(const Drive& drive, const MapSettings& settings,
                               const Progress& progress);

}  // namespace rack::mapping
