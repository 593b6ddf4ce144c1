// Finds the board in a picture, by OpenCV. Pure.
#pragma once

#include <optional>
#include <vector>

#include "tools/camera_calibrate/board.h"
#include "tools/camera_calibrate/grey_image.h"

namespace rack::camera_calibrate {

// The points of the whole board in the order of positions(), with a fraction of a pixel. Empty: the
// picture does not show the whole board.
std::optional<std::vector<PicturePoint>> find_board(const GreyImage& image, const Board& board);

}  // namespace rack::camera_calibrate
