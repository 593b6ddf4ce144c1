// A map of a building out of a recorded drive through it. Pure.
//
// Four steps: each scan is laid on those before it (keyframes.h), places that were visited again
// are found (loops.h), all scans are laid on all that see the same walls, again and again while all
// poses are moved to where they agree best (Lu and Milios 1997), and cells are told free from
// occupied by counting how many beams end in them and how many pass through.
#pragma once

#include "components/localisation/grid_map.h"
#include "components/mapping/loops.h"

namespace rack::mapping {

struct MapSettings {
  double resolution = 50;    // mm
  double range_max = 30000;  // mm: beams that are longer are not drawn
  int rounds = 3;            // of laying all scans on all others
};

struct MadeMap {
  localisation::GridMap map{};
  std::vector<Pose> poses{};  // of the robot at each scan of the drive
  std::size_t keyframes = 0;
  std::size_t searched = 0;   // keyframes where the odometry had jumped
  std::size_t unmatched = 0;  // keyframes where only the odometry was left
  std::size_t loops = 0;      // places visited again, by keyframes that were searched for
  std::size_t edges = 0;
  double way = 0;  // mm
};

// kClosed: `progress` said so; kMalformed: nothing in the drive to make a map of.
tims::Result<MadeMap> make_map(const Drive& drive, const MapSettings& settings,
                               const Progress& progress);

}  // namespace rack::mapping
