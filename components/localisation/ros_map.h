// A map in the format of ROS's map_server: an image (PGM, PNG) with the occupancy of each cell, and
// a small YAML file with resolution and origin. Pure: the caller opens and decodes the image by the
// file name from the YAML file (components/pictures/grey_picture.h).
//
// The lowest row of the image has the smallest y of ROS. Dark is occupied: p = (max - value) / max,
// or value / max with `negate`. A cell is occupied above occupied_thresh and free below
// free_thresh, also with `mode: scale`; with `mode: raw` the values are per cent. ROS has x to the
// right and y up in the image; RACK has y and x.
#pragma once

#include <string>
#include <string_view>

#include "components/geometry/pose.h"
#include "components/localisation/grid_map.h"
#include "components/pictures/grey_picture.h"

namespace rack::localisation {

struct RosMapInfo {
  std::string image{};    // file name, relative to that of the YAML file
  double resolution = 0;  // m
  double origin_x = 0;    // m: the lower left corner of the image
  double origin_y = 0;    // m
  bool negate = false;
  bool is_raw = false;  // values are per cent instead of grey values
  double occupied_thresh = 0.65;
  double free_thresh = 0.196;
};

// Error kMalformed: "line 3: ...".
tims::Result<RosMapInfo> read_ros_yaml(std::string_view text);
GridMap grid_of(const RosMapInfo& info, const pictures::GreyPicture& picture);

// The reverse: a binary image and its YAML file.
std::string to_pgm(const GridMap& map);
std::string to_ros_yaml(const GridMap& map, std::string_view image);

// Converts between poses of ROS and CARMEN (m, rad, counter-clockwise from x to the right) and of
// RACK.
Pose pose_of_ros(double x, double y, double theta);
struct RosPose {
  double x;      // m
  double y;      // m
  double theta;  // rad
};
RosPose ros_of_pose(const Pose& pose);

}  // namespace rack::localisation
