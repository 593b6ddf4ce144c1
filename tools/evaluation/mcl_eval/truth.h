// Ground truth from files of public data sets, and the error of a trajectory. Pure.
//
// Poses, in the frame of the map: lines `time index x y theta` (index of the scan in the log, from
// 0), `time x y theta` (logger time or own time of the scan), or `time x y z qx qy qz qw` (TUM data
// sets). Relations between two scans, identified by their own times: `time1 time2 dx dy dz roll
// pitch yaw`. Units: m, rad, s; lines with # are comments. The number of fields in the first line
// determines the format.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "components/localisation/carmen_log.h"

namespace rack::mcl_eval {

struct TruePose {
  std::size_t scan;  // index in the log
  Pose laser;
};

struct Relation {
  std::size_t from;  // indices of scans in the log
  std::size_t to;
  Pose step;  // pose of scan `to` in the frame of scan `from`
};

struct Truth {
  std::vector<TruePose> poses{};  // poses or relations is empty
  std::vector<Relation> relations{};
  std::size_t beside = 0;  // number of lines without a scan of that time
};

// kMalformed: "line 17: ...".
tims::Result<Truth> read_truth(std::string_view text, const localisation::CarmenLog& log);

// The error of a trajectory that was estimated from a log.
//
// With relations (Kuemmerle et al. 2009): the difference of each relative pose to the true one.
// With poses: the trajectory is first aligned by the rigid transformation of least squares, because
// its frame is arbitrary.
struct TrackError {
  std::vector<double> metres{};
  std::vector<double> degrees{};
};
// `laser`: the estimated pose of the laser for each scan of the log.
TrackError track_error(std::span<const Pose> laser, const Truth& truth);

}  // namespace rack::mcl_eval
