// A scan of space as a picture for people, and as text. Pure.
//
// Each flat scan is a row, each of its points a pixel that says how far away it is. The original's
// graphical interface draws the rows of a pitching scanner mirrored: it expects the ladar to count
// its points from the right. All others it takes as they are.
#pragma once

#include <string>

#include "rack/proxies/scan3d.h"

namespace rack::scan3d {

// Of a scan whose points are not compressed. What is missing at its end is invalid, what is too
// much is left out.
Scan3dRangeImageData range_image(const Scan3dData& scan);

// A line a point: x y z type segment intensity.
std::string point_lines(const Scan3dData& scan);

}  // namespace rack::scan3d
