// A laser scan as points of the robot (specification, section 10.4). Pure.
//
// Each distance becomes a point by the angle of its ray and the place where the ladar is mounted;
// one that hangs upside down is read from its end. A median over three neighbours takes out single
// points.
//
// Points of a scan are measured one after the other while the robot drives on. Where its way during
// the scan is known, each is put where it is seen from the middle of the scan, which is the time of
// the scan: without, walls are bent by as much as the robot turns in half of it.
//
// A wall of metal or paint that the ray meets at right angles shines as a reflector does. It is
// told from one by its neighbours: a straight line is laid through the points around it that follow
// without a gap (total least squares: the main axis of their scatter), and where the ray meets this
// line within 15 degrees of a right angle, the point is a wall again. Three reflectors side by side
// are believed.
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
  bool is_reversed = false;  // its last point is measured first (SICK LMS200)
};

struct ScanFilter {
  i32 range_max = 30000;     // mm
  i32 reduce = 1;            // each so many-th point
  double angle_min = -3.15;  // of the ladar as if it stood upright, rad
  double angle_max = 3.15;   // rad
  bool median = false;       // of three: single points that stick out are noise
  // A wall seen at right angles shines like a reflector: those that lie on one are none, unless
  // there are three side by side.
  bool reflectors = false;
};

// Allocates nothing once `scan` has the room. refPos stays as it is. Points are in the order of
// their angles, also of a ladar upside down. `way`: of the robot from the first point that was
// measured to the last one.
void convert(const LadarData& ladar, const LadarMounting& mounting, const ScanFilter& filter,
             Scan2dData& scan, const Pose& way = {});

// The way during a scan, from where odometry was at two times: as if it went on so. Stands still
// when there is no time between them, or they are no way that a robot goes.
Pose way_during_scan(const Pose& before, const Pose& now, double ms_between, double ms_of_scan);

// The intensities of that scan, from the camera that the ladar is, too: a row or a column of 12 or
// 16 bits, high byte first. kInvalidArgument: it is no such picture, or not of that scan.
tims::Result<void> add_intensities(const CameraData& camera, Scan2dData& scan);

}  // namespace rack::scan2d
