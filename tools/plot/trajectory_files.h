// Tracks out of what was recorded. Pure: texts come in.
//
// Which kind of file it is, the text itself says:
//   "% Position(0/0)"       a recording of DatalogRec or of the original's, any class with pos.x
//   and
//                           pos.y; of Path the last path in it
//   FLASER, ROBOTLASER1     a log of CARMEN: its odometry
//   4 or 5 numbers a line   true poses of public data sets: `time [index] x y theta` (m, rad, as
//   ROS
//                           has them)
//   words, then numbers     columns with their names, between commas, semicolons or blanks: what
//                           `mcl-eval --poses` and `timsctl msg echo -o csv` write, and everybody
//
// Columns: time_s or recordingTime (ms); x_m and y_m, or pos.x and pos.y (mm), with a name in front
// (truth_x_m) for further tracks; what else ends with _m, _deg or _mps and is called error or speed
// is drawn over time. x is to the north, y to the east. Fields may be empty.
#pragma once

#include <string>
#include <string_view>

#include "tims/result.h"
#include "tools/plot/picture.h"

namespace rack::plot {

// Adds what is in it; `name` is what its tracks are called, empty: what the file calls them. A name
// that begins with "truth", "odometry", "path" or "estimate" says what it is. kMalformed: "line 17:
// ...", or what is missing.
tims::Result<void> add_file(std::string_view text, std::string_view name, Picture& picture);

// Of a path: points along it.
Track track_of(const std::vector<PolarSpline>& splines, std::string name);

}  // namespace rack::plot
