// Recorded drives as CARMEN wrote them, the form in which most public laser logs are. Pure.
//
// A message a line. Read are ODOM (x y theta tv rv accel), FLASER (count, ranges, pose of the
// laser, pose of the robot by odometry), ROBOTLASER1 (with the scanner's geometry before the
// ranges) and RAWLASER1 (the same without poses: where the odometry was then, it is), each with ipc
// time, host, logger time behind; other messages are passed over. Metres, radians,
// counter-clockwise; FLASER sweeps from right to left, half a turn unless its number of beams is
// that of another scanner (270 degrees: 271, 541, 811, 1081; 100 degrees: 101, 201, 401).
//
// Scans of such logs are often older than the odometry in the same line. OdometryHistory says
// where the odometry was at any time, estimate_lag() how late it is: while the robot turns, how far
// it turned between two scans is seen by the scans themselves, and of all lags the one is taken for
// which the odometry says the same.
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
  // Samples that are not newer than the newest are left out.
  void add(double time, const Pose& pose);
  // Between two samples, or the first or last one. At least one was added.
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
  double time = 0;         // s, by the program that read the scanner
  double logger_time = 0;  // s, since the log began
  Pose odometry{};         // of the robot, as in the line, RACK's axes
  Pose laser{};            // on the robot
  double first = 0;        // rad clockwise from ahead: of the first beam
  double step = 0;         // rad
  std::size_t begin = 0;   // in CarmenLog::ranges
  std::size_t count = 0;
  bool is_raw = false;  // its line had no poses
};

struct CarmenLog {
  std::vector<LogScan> scans{};
  std::vector<float> ranges{};  // m
  OdometryHistory odometry{};
  double range_max = 0;  // m: what is as long as this saw nothing

  // The ends of the beams of a scan in the frame of the robot, without those that saw nothing.
  void beams(const LogScan& scan, std::vector<BeamEnd>& ends) const;
  // Where the odometry was when the scan was made, `lag` before the time that it says. Without lag
  // as the line says.
  [[nodiscard]] Pose odometry_of(const LogScan& scan, double lag) const;
};

// kMalformed: "line 17: ...". Refused are also logs without scans.
// `field`: deg that FLASER sweeps; 0: the usual one.
tims::Result<CarmenLog> read_carmen(std::string_view text, double field = 0);

// 0 to 0.3 s; 0 when it cannot be told.
double estimate_lag(const CarmenLog& log);

}  // namespace rack::localisation
