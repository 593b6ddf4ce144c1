// A map in the format of ROS's map_server: an image (PGM, PNG) with the occupancy of each cell, and
// its description (ros_yaml.h). Pure: the caller opens, decodes and encodes the image by the file
// name from the description (components/pictures/grey_picture.h).
//
// The lowest row of the image has the smallest y of ROS. Dark is occupied: p = (max - value) / max,
// or value / max with `negate`. A cell is occupied above occupied_thresh and free below
// free_thresh, also with `mode: scale`; with `mode: raw` the values are per cent. ROS has x to the
// right and y up in the image; RACK has y and x.
#pragma once

#include "components/geometry/pose.h"
#include "components/localisation/grid_map.h"
#include "components/localisation/ros_yaml.h"
#include "components/pictures/grey_picture.h"

namespace rack::localisation {

GridMap grid_of(const RosMapInfo& info, const pictures::GreyPicture& picture);

// The reverse, with the grey values of ROS's map_saver; pictures::write_grey() encodes the image.
pictures::GreyPicture grey_of(const GridMap& map);

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
