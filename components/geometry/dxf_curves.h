// Curves of drawings as chords of at most 5 degrees.
#pragma once

#include <vector>

#include "components/geometry/dxf.h"

namespace rack {

struct DxfEllipse {
  DxfPoint centre;
  DxfPoint major;  // from the centre to the end of an axis
  DxfPoint minor;
};

inline DxfEllipse dxf_circle(const DxfPoint& centre, double radius) {
  return {centre, {radius, 0}, {0, radius}};
}

// The part from the parameter `first` on, over `sweep`, both in radians from the major axis to the
// minor one: at least two points.
std::vector<DxfPoint> chords(const DxfEllipse& ellipse, double first, double sweep);

// From the angle `first` to `last` counter-clockwise: more than 0, at most 2 pi.
double dxf_sweep(double first, double last);

// Appends the points of a segment of a polyline, without `from` and with `to`. The bulge is the
// tangent of a quarter of the included angle, more than 0 when the arc runs counter-clockwise.
void add_bulge(DxfPoint from, DxfPoint to, double bulge, std::vector<DxfPoint>& points);

}  // namespace rack
