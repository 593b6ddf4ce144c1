// Converts a laser scan to points in the robot's frame (specification, section 10.4). Pure.
//
// Each range becomes a point by the angle of its ray and the mounting pose of the ladar; a ladar
// mounted upside down is read from its end. A median over three neighbours removes single outliers.
//
// The points of a scan are measured one after the other while the robot moves. When the movement
// during the scan is known, each point is transformed to the robot's pose in the middle of the
// scan, which is the time of the scan. Otherwise walls are bent by the rotation of the robot during
// half of the scan.
//
// A wall of metal or paint hit at a right angle has the intensity of a reflector. Its neighbours
// show the difference: a straight line is fitted to the points around it that follow without a gap
// (total least squares: the main axis of their scatter), and where the ray meets this line within
// 15 degrees of a right angle, the point is classified as a wall again. Three adjacent reflectors
// are kept.
#pragma once

#include "components/geometry/pose.h"
#include "rack/proxies/camera.h"
#include "rack/proxies/ladar.h"
#include "rack/proxies/scan2d.h"
#include "tims/result.h"

namespace rack::scan2d {

struct LadarMounting {
  i32 x = 0;       // of the ladar on the robot, mm
  i32 y = 0;       // mm
  double rho = 0;  // rad
  bool upside_down = false;
  bool is_reversed = false;  // the last point is measured first (SICK LMS200)
};

struct ScanFilter {
  i32 range_max = 30000;     // mm
  i32 reduce = 1;            // every n-th point is used
  double angle_min = -3.15;  // of the ladar if mounted upright, rad
  double angle_max = 3.15;   // rad
  bool median = false;       // of three points, removes single outliers
  // Reclassifies reflectors on a wall that is seen at a right angle, unless three are adjacent.
  bool reflectors = false;
};

// Allocates nothing when `scan` has capacity. refPos is not changed. Points are in the order of
// their angles, also for a ladar upside down. `motion`: movement of the robot from the first
// measured point to the last one.
void convert(const LadarData& ladar, const LadarMounting& mounting, const ScanFilter& filter,
             Scan2dData& scan, const Pose& motion = {});

// The movement during a scan, extrapolated from the odometry at two times. Zero when the times are
// equal, or when the movement is physically impossible.
Pose motion_during_scan(const Pose& before, const Pose& now, double ms_between, double ms_of_scan);

// Sets the intensities of the scan from the camera interface of the same ladar: a row or a column
// of 12 or 16 bits, high byte first. kInvalidArgument: the image has another format, or is not of
// that scan.
tims::Result<void> add_intensities(const CameraData& camera, Scan2dData& scan);

}  // namespace rack::scan2d
