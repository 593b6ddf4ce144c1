// A 3D scan as a range image, and as text. Pure.
//
// Each flat scan is a row; each pixel is the range of a point. The original's graphical interface
// mirrors the rows of a pitching scanner: it expects the ladar to count its points from the right.
// All other modes are not mirrored.
#pragma once

#include <string>

#include "rack/proxies/scan3d.h"

namespace rack::scan3d {

// The points of the scan must not be compressed. Missing pixels at the end are invalid, excess
// points are dropped.
Scan3dRangeImageData range_image(const Scan3dData& scan);

// One line per point: x y z type segment intensity.
std::string point_lines(const Scan3dData& scan);

}  // namespace rack::scan3d
