// Pictures of files and of a Camera as 8 bit grey. Pure.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "rack/proxies/camera.h"
#include "tims/result.h"

namespace rack::camera_calibrate {

struct GreyImage {
  int width = 0;
  int height = 0;
  std::vector<std::byte> pixels{};  // width * height
};

// PNG, PGM or JPEG. kMalformed: what is wrong with the picture.
tims::Result<GreyImage> grey_of_file(std::string_view bytes);

// mono8, mono16, rgb24, yuv422 and jpeg. kInvalidArgument: another mode.
tims::Result<GreyImage> grey_of(const CameraData& picture);

tims::Result<std::string> png_of(const GreyImage& image);

}  // namespace rack::camera_calibrate
