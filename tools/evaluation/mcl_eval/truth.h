// Where a robot truly was, as files of public data sets say it, and how far a track is from it.
// Pure.
//
// Poses: a line `time index x y theta` (index of the scan in the log, from 0) or `time x y theta`
// (the time of the scan in the log, by its logger or its own), or `time x y z qx qy qz qw` (as the
// TUM data sets have them), in the frame of the map. Relations: `time1 time2 dx dy dz roll
// pitch yaw`, what was measured between two scans, by their own times. Metres, radians, seconds;
// lines with # are remarks. Which of them a file is, its first line says by its number of words.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "components/localisation/carmen_log.h"

namespace rack::mcl_eval {

struct TruePose {
  std::size_t scan;  // of the log
  Pose laser;
};

struct Relation {
  std::size_t from;  // scans of the log
  std::size_t to;
  Pose step;  // from there as seen from here
};

struct Truth {
  std::vector<TruePose> poses{};  // one of the two is empty
  std::vector<Relation> relations{};
  std::size_t beside = 0;  // lines whose time no scan of the log has
};

// kMalformed: "line 17: ...".
tims::Result<Truth> read_truth(std::string_view text, const localisation::CarmenLog& log);

// How far a track that was made from a log is from the truth.
//
// With relations (Kuemmerle et al. 2009): for each, how the step between its two scans differs from
// the one that was measured. With poses: the track is laid on them as a whole first (the rigid
// motion of least squares), as nobody told the map maker where north is.
struct TrackError {
  std::vector<double> metres{};
  std::vector<double> degrees{};
};
// `laser`: of each scan of the log.
TrackError track_error(std::span<const Pose> laser, const Truth& truth);

}  // namespace rack::mcl_eval
