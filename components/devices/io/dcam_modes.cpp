#include "components/devices/io/dcam_modes.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "components/devices/core/video_frame.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;

constexpr std::array kBayer = {video::kRggb, video::kGbrg, video::kGrbg, video::kBggr};
constexpr std::array kBayer16 = {video::kRggb16, video::kGbrg16, video::kGrbg16, video::kBggr16};

// Which filter a camera has is known when it sends: a request for one pattern fits all.
bool fits(dc1394color_coding_t coding, std::uint32_t format) {
  if (coding == DC1394_COLOR_CODING_RAW8) return std::ranges::count(kBayer, format) > 0;
  if (coding == DC1394_COLOR_CODING_RAW16) return std::ranges::count(kBayer16, format) > 0;
  return format == (format_of(coding, DC1394_COLOR_FILTER_RGGB) & ~video::kBigEndian);
}

bool has_size(const DcamMode& mode, const VideoRequest& request) {
  if (request.width == 0 || request.height == 0) return true;
  if (!mode.is_scalable()) return request.width == mode.width && request.height == mode.height;
  return request.width <= mode.width && request.height <= mode.height &&
         request.width % mode.width_step == 0 && request.height % mode.height_step == 0;
}

DcamRate rate_for(const DcamMode& mode, double wanted) {
  DcamRate best{};
  for (const DcamRate& rate : mode.rates) {
    const bool is_enough = wanted > 0 && best.hertz >= wanted;
    if (is_enough ? rate.hertz >= wanted && rate.hertz < best.hertz : rate.hertz > best.hertz)
      best = rate;
  }
  return best;
}

std::string format_name(const DcamMode& mode) {
  switch (mode.coding) {
    case DC1394_COLOR_CODING_RAW8:
      return "raw8";
    case DC1394_COLOR_CODING_RAW16:
      return "raw16";
    case DC1394_COLOR_CODING_YUV411:
      return "YUV411";
    case DC1394_COLOR_CODING_YUV444:
      return "YUV444";
    default: {
      const std::uint32_t format = format_of(mode.coding, DC1394_COLOR_FILTER_RGGB);
      return format == 0 ? "other" : letters_of(format & ~video::kBigEndian);
    }
  }
}

std::string text_of(std::span<const DcamMode> modes) {
  std::string text;
  for (const DcamMode& mode : modes)
    text += (text.empty() ? "" : ", ") + std::string(mode.is_scalable() ? "up to " : "") +
            std::to_string(mode.width) + "x" + std::to_string(mode.height) + " " +
            format_name(mode);
  return text.empty() ? "none" : text;
}

}  // namespace

std::uint32_t format_of(dc1394color_coding_t coding, dc1394color_filter_t filter) {
  const auto index = static_cast<std::size_t>(filter - DC1394_COLOR_FILTER_MIN);
  switch (coding) {
    case DC1394_COLOR_CODING_MONO8:
      return video::kGrey;
    case DC1394_COLOR_CODING_YUV422:
      return video::kUyvy;
    case DC1394_COLOR_CODING_RGB8:
      return video::kRgb24;
    case DC1394_COLOR_CODING_MONO16:
      return video::kGrey16 | video::kBigEndian;
    case DC1394_COLOR_CODING_RAW8:
      return index < kBayer.size() ? kBayer.at(index) : 0;
    case DC1394_COLOR_CODING_RAW16:
      return index < kBayer16.size() ? kBayer16.at(index) | video::kBigEndian : 0;
    default:
      return 0;
  }
}

Result<DcamChoice> choose_mode(std::span<const DcamMode> modes, const VideoRequest& request) {
  const auto take = [&](const DcamMode& mode) {
    const bool is_any = request.width == 0 || request.height == 0;
    return DcamChoice{.mode = mode,
                      .width = is_any ? mode.width : request.width,
                      .height = is_any ? mode.height : request.height,
                      .rate = rate_for(mode, request.rate)};
  };
  std::vector<std::uint32_t> formats = request.formats;
  if (formats.empty()) formats = {video::kUyvy, video::kRgb24, video::kGrey, video::kRggb};
  for (const std::uint32_t format : formats)
    for (const bool is_scalable : {false, true}) {
      const DcamMode* best = nullptr;
      for (const DcamMode& mode : modes)
        if (mode.is_scalable() == is_scalable && (is_scalable || !mode.rates.empty()) &&
            fits(mode.coding, format) && has_size(mode, request) &&
            (best == nullptr ||
             std::uint64_t{mode.width} * mode.height > std::uint64_t{best->width} * best->height))
          best = &mode;
      if (best != nullptr) return take(*best);
    }
  std::string wanted;
  for (const std::uint32_t format : formats)
    wanted += (wanted.empty() ? "" : ", ") + letters_of(format);
  return Error(Errc::kInvalidArgument, "does not send " + std::to_string(request.width) + "x" +
                                           std::to_string(request.height) + " as " + wanted +
                                           "; it has: " + text_of(modes));
}

std::uint32_t packet_bytes(std::uint64_t frame_bytes, double rate, std::uint32_t step,
                           std::uint32_t max) {
  constexpr double kPacketsPerSecond = 8000;
  if (rate <= 0 || step == 0) return max;
  const double packets = std::max(1.0, std::floor(kPacketsPerSecond / rate));
  const double bytes = std::ceil(static_cast<double>(frame_bytes) / packets / step) * step;
  return static_cast<std::uint32_t>(std::clamp<double>(bytes, std::min(step, max), max));
}

}  // namespace rack::device
