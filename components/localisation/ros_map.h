// A map as ROS's map_server reads and writes it: a picture (PGM) of how occupied each cell is, and
// a small YAML file that says where it lies. Pure: bytes come in, and the name of the picture goes
// out for somebody who can open files.
//
// The picture's lowest row is the one with the smallest y of ROS. Dark is occupied: p = (max -
// value) / max, the other way round with `negate`; above occupied_thresh a cell is occupied, below
// free_thresh free; of `mode: scale` as well, and with `mode: raw` the values are per cent already.
// ROS has x to the right and y up in the picture, RACK y and x.
#pragma once

#include <string>
#include <string_view>

#include "components/geometry/pose.h"
#include "components/localisation/grid_map.h"

namespace rack::localisation {

struct RosMapInfo {
  std::string image{};    // file name, relative to that of the YAML file
  double resolution = 0;  // m
  double origin_x = 0;    // m: the lower left corner of the picture
  double origin_y = 0;    // m
  bool negate = false;
  bool is_raw = false;  // values are per cent, not shades
  double occupied_thresh = 0.65;
  double free_thresh = 0.196;
};

// kMalformed: "line 3: ...".
tims::Result<RosMapInfo> read_ros_yaml(std::string_view text);
// PGM, as text (P2) or binary (P5).
tims::Result<GridMap> read_ros_map(const RosMapInfo& info, std::string_view pgm);

// The same way out: a binary picture, and what says where it lies.
std::string to_pgm(const GridMap& map);
std::string to_ros_yaml(const GridMap& map, std::string_view image);

// The same place and direction: m and rad counter-clockwise from x to the right, as ROS and CARMEN
// have them, and RACK's.
Pose pose_of_ros(double x, double y, double theta);
struct RosPose {
  double x;      // m
  double y;      // m
  double theta;  // rad
};
RosPose ros_of_pose(const Pose& pose);

}  // namespace rack::localisation
