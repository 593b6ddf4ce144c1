// Points, positions and splines that several classes use (specification, section 9.0).
//
// Robot frame: x forward, y to the right, z down. Angles are clockwise seen from above: phi about
// x, psi about y, rho (heading) about z. World frame: x north, y east, z down. rho is in the range
// 0 to 2 pi, the other angles in -pi to pi. All message structs keep the field names of the
// original, because recordings and other programs use them.
#pragma once

#include "rack/codec/quantity.h"

namespace rack {

struct Position2d {
  Millimetres<i32> x = 0;
  Millimetres<i32> y = 0;
  Radians<f32> rho = 0;
};

struct Position3d {
  Millimetres<i32> x = 0;
  Millimetres<i32> y = 0;
  Millimetres<i32> z = 0;
  Radians<f32> phi = 0;
  Radians<f32> psi = 0;
  Radians<f32> rho = 0;
};

struct Velocity3d {
  MillimetresPerSecond<i32> x = 0;
  MillimetresPerSecond<i32> y = 0;
  MillimetresPerSecond<i32> z = 0;
  RadiansPerSecond<f32> phi = 0;
  RadiansPerSecond<f32> psi = 0;
  RadiansPerSecond<f32> rho = 0;
};

struct Point2d {
  Millimetres<i32> x = 0;
  Millimetres<i32> y = 0;
};

struct Point3d {
  Millimetres<i32> x = 0;
  Millimetres<i32> y = 0;
  Millimetres<i32> z = 0;
};

struct ImageRect {
  Pixels<i32> x = 0;
  Pixels<i32> y = 0;
  Pixels<i32> width = 0;
  Pixels<i32> height = 0;
};

struct DestinationPoint {
  Position3d pos = {};
  MillimetresPerSecond<i32> speed = 0;
};

struct Waypoint2d {
  Millimetres<i32> x = 0;
  Millimetres<i32> y = 0;
  MillimetresPerSecond<i32> speed = 0;
  Millimetres<i32> maxRadius = 0;  // largest allowed turning radius, absolute
  i32 type = 0;
  i32 request = 0;           // flags
  Millimetres<i32> lbo = 0;  // lateral boundary offset
  i32 id = 0;
  i32 wayId = 0;
  i32 layer = 0;
  i32 actionStart = 0;
  i32 actionEnd = 0;
};

struct PolarSpline {
  Waypoint2d basepoint = {};  // end of this spline
  Position2d startPos = {};
  Position2d endPos = {};
  Position2d centerPos = {};           // centre and frame of the spline
  Millimetres<i32> length = 0;         // signed
  Millimetres<i32> radius = 0;         // 0: straight line; the sign gives the side
  MillimetresPerSecond<i32> vMax = 0;  // speeds are absolute
  MillimetresPerSecond<i32> vStart = 0;
  MillimetresPerSecond<i32> vEnd = 0;
  MillimetresPerSecond2<i32> accMax = 0;
  MillimetresPerSecond2<i32> decMax = 0;
  i32 type = 0;
  i32 request = 0;
  Millimetres<i32> lbo = 0;
};

// A point of a 2D or 3D scan; `type` is a combination of the bits below.
struct ScanPoint {
  Millimetres<i32> x = 0;  // robot frame
  Millimetres<i32> y = 0;
  Millimetres<i32> z = 0;  // 2D scans: the measured range
  i32 type = 0;
  i16 segment = 0;
  i16 intensity = 0;
};

namespace scan_point {
inline constexpr i32 kInvalid = 0x10;
inline constexpr i32 kMaxRange = 0x20;
inline constexpr i32 kReduce = 0x40;
inline constexpr i32 kReflector = 0x80;
inline constexpr i32 kHorizontalEdge = 0x08;  // 3D
inline constexpr i32 kEdge = 0x04;            // 3D: vertical edge
// 2D: 1 landmark, 2 obstacle, 3 dynamic obstacle; 3D: 1 object, 2 ground, 3 ceiling; 0 unknown
inline constexpr i32 kClassMask = 0x03;
}  // namespace scan_point

}  // namespace rack
