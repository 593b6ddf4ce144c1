// Recorded drives in the log format of CARMEN, which most public laser logs use. Pure.
//
// One message a line. The reader accepts ODOM (x y theta tv rv accel), FLASER (count, ranges, pose
// of the laser, pose of the robot by odometry), ROBOTLASER1 (with the scanner's geometry before the
// ranges) and RAWLASER1 (the same without poses: the pose of the robot is interpolated from ODOM).
// Each ends with the ipc time, host name and logger time. Other messages are skipped. Units are
// metres and radians, counter-clockwise. FLASER sweeps from right to left over 180 degrees, unless
// its number of beams is that of another scanner (270 degrees: 271, 541, 811, 1081; 100 degrees:
// 101, 201, 401).
//
// Scans of such logs are often older than the odometry in the same line. OdometryHistory gives the
// pose of the odometry at any time. estimate_lag() determines the lag: while the robot turns, the
// rotation between two scans follows from matching the scans, and the lag is the one for which the
// odometry agrees best.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "components/geometry/pose.h"
#include "components/localisation/likelihood_field.h"
#include "tims/result.h"

namespace rack::localisation {

class OdometryHistory {
 public:
  // Ignores samples that are not newer than the newest one.
  void add(double time, const Pose& pose);
  // Interpolates between two samples; outside of them, the first or the last one. At least one
  // sample was added.
  [[nodiscard]] Pose at(double time) const;
  [[nodiscard]] bool empty() const { return samples_.empty(); }

 private:
  struct Sample {
    double time;  // s
    Pose pose;
  };
  std::vector<Sample> samples_;
};

struct LogScan {
  double time = 0;         // s, ipc time: set by the program that read the scanner
  double logger_time = 0;  // s, since the start of the log
  Pose odometry{};         // of the robot, from the line, in RACK's axes
  Pose laser{};            // on the robot
  double first = 0;        // rad, of the first beam, clockwise from ahead
  double step = 0;         // rad, between two beams
  std::size_t begin = 0;   // index in CarmenLog::ranges
  std::size_t count = 0;
  bool is_raw = false;  // the line had no poses
};

struct CarmenLog {
  std::vector<LogScan> scans{};
  std::vector<float> ranges{};  // m
  OdometryHistory odometry{};
  double range_max = 0;      // m; a range of this length hit nothing
  std::size_t cut_line = 0;  // number of an incomplete last line, which was left out; 0: none

  // The end points of the beams that hit something, in the frame of the robot.
  void beams(const LogScan& scan, std::vector<BeamEnd>& ends) const;
  // The odometry at the time of the scan minus `lag`. With lag 0, the pose from the line.
  [[nodiscard]] Pose odometry_of(const LogScan& scan, double lag) const;
};

// Error kMalformed: "line 17: ...". Logs without scans are refused. A last line without its end was
// being written when the recording program ended: if it is incomplete, it is left out. `field`:
// deg, field of view of FLASER scans; 0: derived from the number of beams.
tims::Result<CarmenLog> read_carmen(std::string_view text, double field = 0);

// 0 to 0.3 s; 0 when the log does not allow an estimate.
double estimate_lag(const CarmenLog& log);

}  // namespace rack::localisation
