// Finds the reason of a failure in what FFmpeg, GStreamer and OpenCV have printed. Pure.
#pragma once

#include <string>
#include <string_view>

namespace rack::device {

// The line that explains most, without places in sources, addresses of memory and passwords; empty
// if there is none.
std::string reason_in_log(std::string_view log);

}  // namespace rack::device
