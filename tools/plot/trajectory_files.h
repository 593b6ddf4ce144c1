// Reads trajectories from recordings. Pure: the input is text.
//
// The format is recognised from the text:
//   "% Position(0/0)"        a recording of DatalogRec or the original RACK, of any class with
//   pos.x
//                            and pos.y; of a Path: its last path
//   FLASER, ROBOTLASER1      a CARMEN log: its odometry
//   4 or 5 numbers per line  true poses of public data sets: `time [index] x y theta` (m, rad, in
//                            the frame of ROS)
//   names, then numbers      named columns, separated by commas, semicolons or blanks: output of
//                            `mcl-eval --poses`, `timsctl msg echo -o csv` and other programs
//
// Columns: time_s or recordingTime (ms); x_m and y_m, or pos.x and pos.y (mm), with a prefix
// (truth_x_m) for further trajectories; other columns named error or speed with _m, _deg or _mps
// are drawn over time. x is north, y is east. Fields may be empty.
#pragma once

#include <string>
#include <string_view>

#include "tims/result.h"
#include "tools/plot/picture.h"

namespace rack::plot {

// Adds the content of a file to the picture. `name`: the name of its trajectories; empty: from the
// file. A name that begins with "truth", "odometry", "path" or "estimate" determines the role.
// kMalformed: "line 17: ...", or what is missing.
tims::Result<void> add_file(std::string_view text, std::string_view name, Picture& picture);

// Samples points along a path.
Trajectory trajectory_of(const std::vector<PolarSpline>& splines, std::string name);

}  // namespace rack::plot
