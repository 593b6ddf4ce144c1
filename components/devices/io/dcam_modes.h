// What an IIDC camera can send, and which of it fits a request.
//
// Fixed modes have a size, a coding of pixels and a list of rates. Scalable modes (format 7) have
// any window of the sensor; the size of the packets determines their rate.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <dc1394/dc1394.h>

#include "components/devices/io/video_request.h"

namespace rack::device {

struct DcamRate {
  dc1394framerate_t id{};
  double hertz = 0;
};

struct DcamMode {
  dc1394video_mode_t id{};
  dc1394color_coding_t coding{};
  std::uint32_t width = 0;  // of scalable modes: the largest
  std::uint32_t height = 0;
  std::uint32_t width_step = 0;  // 0: a fixed mode
  std::uint32_t height_step = 0;
  std::vector<DcamRate> rates{};  // of fixed modes

  [[nodiscard]] bool is_scalable() const { return width_step != 0; }
};

struct DcamChoice {
  DcamMode mode{};
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  DcamRate rate{};  // of fixed modes: the lowest one that is sufficient, or the highest
};

// The mode of the first requested format that has the size; a fixed one if there is one. The error
// lists what the camera has.
tims::Result<DcamChoice> choose_mode(std::span<const DcamMode> modes, const VideoRequest& request);

// The pixel format (video_frame.h) of a coding, of Bayer patterns by the filter; 0: not supported.
std::uint32_t format_of(dc1394color_coding_t coding, dc1394color_filter_t filter);

// Bytes per packet for `rate` frames of this size per second: a multiple of `step`. The bus carries
// 8000 packets per second, and what a camera does not use is left for others. Rate 0: `max`.
std::uint32_t packet_bytes(std::uint64_t frame_bytes, double rate, std::uint32_t step,
                           std::uint32_t max);

}  // namespace rack::device
