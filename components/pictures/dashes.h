// Dashed lines: OpenCV draws solid lines only. Pure.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "components/pictures/canvas.h"

namespace rack::pictures {

// "7 3 2 3" as numbers, an odd number of them twice, as in SVG. Empty: no dashes, or lengths that
// are not numbers of at least half a pixel.
std::vector<double> dash_lengths(std::string_view dashes);

// The dashes of a line that are at least partly in the box. A dash continues around corners of the
// line. What is outside the box takes no time, however long it is; segments of ten million pixels
// and more have no dashes.
std::vector<std::vector<Spot>> dashes_of(std::span<const Spot> line, std::span<const double> dashes,
                                         const Box& box);

}  // namespace rack::pictures
