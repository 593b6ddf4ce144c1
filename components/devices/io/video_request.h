// What the options size, format and rate of an address request from a camera.
#pragma once

#include <cstdint>
#include <vector>

#include "rack/devices/device_address.h"

namespace rack::device {

struct VideoRequest {
  std::vector<std::uint32_t> formats;  // in order of preference; empty: the camera's first format
  std::uint32_t width = 0;             // 0: current setting of the camera
  std::uint32_t height = 0;
  double rate = 0;  // frames per second; 0: current setting of the camera
};

Result<VideoRequest> video_request(const DeviceAddress& address);

}  // namespace rack::device
