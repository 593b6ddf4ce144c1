// A recorded drive, the input of the map maker: the odometry pose and the end points of the beams
// of each scan. It is read from logs of CARMEN, and from recordings of DatalogRec (one text file
// per component, one file per scan). Pure: the caller opens the files and passes their contents.
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
  Pose odometry{};      // of the robot at the time of the scan
  Pose scanner{};       // on the robot
  std::size_t row = 0;  // index among the log's scans
  std::size_t begin = 0;
  std::size_t count = 0;
};

// End points are in the frame of the robot, in the order of the scanner, without beams that hit
// nothing.
struct Drive {
  std::vector<DriveScan> scans{};
  std::vector<BeamEnd> ends{};
  std::size_t left_out = 0;            // scans without odometry at their time, or without points
  std::vector<std::string> remarks{};  // incomplete lines: "odometry, line 17: ..."

  [[nodiscard]] std::span<const BeamEnd> beams(const DriveScan& scan) const {
    return std::span(ends).subspan(scan.begin, scan.count);
  }
};

// `lag`: delay of the time stamps of scans, s (localisation::estimate_lag).
Drive drive_of(const localisation::CarmenLog& log, double lag);

// The text of the file of a scan; DatalogRec numbers scans from 1.
using ScanFile = std::function<tims::Result<std::string>(std::size_t number)>;

// `odometry`: a file of an Odometry or a Position, `scans`: of a Scan2d. Points that are invalid or
// dynamic are ignored. Error kMalformed: "odometry, line 17: ...".
tims::Result<Drive> read_recording(std::string_view odometry, std::string_view scans,
                                   const ScanFile& scan_file);

}  // namespace rack::mapping
