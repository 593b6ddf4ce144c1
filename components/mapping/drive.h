// A recorded drive as a map is made of it: where the odometry was at each scan, and where the beams
// ended. Two kinds of recordings become one: logs of CARMEN, and what DatalogRec wrote (a text file
// a component, a file of its own for each scan). Pure: whoever can open files hands in their bytes.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "components/localisation/carmen_log.h"
#include "tims/result.h"

namespace rack::mapping {

using localisation::BeamEnd;

struct DriveScan {
  double time = 0;      // s
  Pose odometry{};      // of the robot when the scan was made
  Pose scanner{};       // on the robot
  std::size_t row = 0;  // of the log's scans, from 0
  std::size_t begin = 0;
  std::size_t count = 0;
};

// Ends of beams lie in the frame of the robot, in the order of the scanner, without those that saw
// nothing.
struct Drive {
  std::vector<DriveScan> scans{};
  std::vector<BeamEnd> ends{};
  std::size_t left_out = 0;  // scans without odometry of their time, or of no size

  [[nodiscard]] std::span<const BeamEnd> beams(const DriveScan& scan) const {
    return std::span(ends).subspan(scan.begin, scan.count);
  }
};

// `lag`: how much older scans are than they say, s (localisation::estimate_lag).
Drive drive_of(const localisation::CarmenLog& log, double lag);

// The text of the file of the scan with this number, counted by DatalogRec from 1.
using ScanFile = std::function<tims::Result<std::string>(std::size_t number)>;

// `odometry`: a file of an Odometry or a Position, `scans`: of a Scan2d. Points count if they are
// neither invalid nor dynamic. kMalformed: "odometry, line 17: ...".
tims::Result<Drive> read_recording(std::string_view odometry, std::string_view scans,
                                   const ScanFile& scan_file);

}  // namespace rack::mapping
