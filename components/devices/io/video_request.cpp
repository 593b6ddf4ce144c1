#include "components/devices/io/video_request.h"

#include <optional>
#include <string>

#include "base/text.h"
#include "components/devices/core/video_frame.h"

namespace rack::device {

using tims::Errc;
using tims::Error;

Result<VideoRequest> video_request(const DeviceAddress& address) {
  VideoRequest request;
  const auto value = [&](std::string_view name) -> std::string {
    const auto found = address.options.find(name);
    return found == address.options.end() ? "" : found->second;
  };
  if (const std::string size = value("size"); !size.empty()) {
    const std::size_t x = size.find('x');
    const auto width = tims::base::parse_number<std::uint32_t>(size.substr(0, x));
    const auto height = x == std::string::npos
                            ? std::nullopt
                            : tims::base::parse_number<std::uint32_t>(size.substr(x + 1));
    if (!width || !height)
      return Error(Errc::kInvalidArgument,
                   "size must be WIDTHxHEIGHT, for example 640x480, not " + size);
    request.width = *width;
    request.height = *height;
  }
  if (const std::string rate = value("rate"); !rate.empty()) {
    const auto number = tims::base::parse_number<double>(rate);
    if (!number || !(*number > 0) || *number > 1000)
      return Error(Errc::kInvalidArgument, "rate must be frames per second, not " + rate);
    request.rate = *number;
  }
  const std::string formats = value("format");
  for (std::size_t at = 0; at < formats.size();) {
    const std::string format = formats.substr(at, formats.find(',', at) - at);
    if (format.empty() || format.size() > 4)
      return Error(Errc::kInvalidArgument,
                   "format must be codes of four letters, for example MJPG,YUYV");
    request.formats.push_back(four_letters(format));
    at += format.size() + 1;
  }
  return request;
}

}  // namespace rack::device
