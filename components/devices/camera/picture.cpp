#include "components/devices/camera/picture.h"

#include <algorithm>
#include <array>
#include <string>

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;

struct Mode {
  std::string_view name;
  u16 mode;
  u16 depth;
  std::string_view formats;
};

constexpr std::array<Mode, 7> kModes = {{
    {"mono8", camera_mode::kMono8, 8, "GREY,YUYV,UYVY,MJPG,JPEG,RGB3,BGR3"},
    {"mono16", camera_mode::kMono16, 16, "Y16"},
    {"rgb24", camera_mode::kRgb24, 24, "RGB3,BGR3,YUYV,UYVY,MJPG,JPEG"},
    {"yuv422", camera_mode::kYuv422, 16, "UYVY,YUYV,MJPG,JPEG"},
    {"jpeg", camera_mode::kJpeg, 24, "MJPG,JPEG,YUYV,UYVY,RGB3,BGR3,GREY"},
    {"range", camera_mode::kRange, 16, "Z16,GREY,YUYV,UYVY,MJPG,JPEG"},
    {"disparity", camera_mode::kDisparity, 16, "GREY,YUYV,UYVY,MJPG,JPEG"},
}};

const Mode* find_mode(u16 mode) {
  const auto* const found = std::ranges::find(kModes, mode, &Mode::mode);
  return found == kModes.end() ? nullptr : found;
}

// Empty for JPEG and others.
std::optional<PixelLayout> layout_of_mode(u16 mode) {
  switch (mode) {
    case camera_mode::kMono8:
      return PixelLayout::kGrey;
    case camera_mode::kRgb24:
      return PixelLayout::kRgb;
    case camera_mode::kYuv422:
      return PixelLayout::kUyvy;
    case camera_mode::kMono16:
    case camera_mode::kRange:
      return PixelLayout::kBig16;
    default:
      return std::nullopt;
  }
}

// Numbers of 16 bits are grey values or depths: neither becomes the other.
bool is_possible(std::uint32_t format, u16 mode) {
  if (format == video::kGrey16) return mode == camera_mode::kMono16;
  if (format == video::kDepth16) return mode == camera_mode::kRange;
  if (mode == camera_mode::kJpeg) return layout_of_format(format).has_value();
  const auto from = layout_of_format(format);
  const auto to = layout_of_mode(mode);
  return from && to && PixelConverter::can_convert(*from, *to);
}

void set_size(CameraData& picture, PictureSize size, u16 mode) {
  picture.width = static_cast<u16>(size.width);
  picture.height = static_cast<u16>(size.height);
  picture.depth = depth_of(mode);
  picture.mode = mode;
  picture.colorFilterId = 0;
}

Error cannot(std::uint32_t format, u16 mode) {
  return {Errc::kInvalidArgument, "frames of format " + letters_of(format) +
                                      " cannot be converted to mode " +
                                      std::string(name_of_mode(mode))};
}

}  // namespace

std::optional<u16> mode_of(std::string_view name) {
  const auto* const found = std::ranges::find(kModes, name, &Mode::name);
  if (found == kModes.end()) return std::nullopt;
  return found->mode;
}

std::string_view name_of_mode(u16 mode) {
  const Mode* const found = find_mode(mode);
  return found == nullptr ? "?" : found->name;
}

u16 depth_of(u16 mode) {
  const Mode* const found = find_mode(mode);
  return found == nullptr ? u16{0} : found->depth;
}

std::string_view formats_for(u16 mode) {
  const Mode* const found = find_mode(mode);
  return found == nullptr ? "" : found->formats;
}

std::optional<PixelLayout> layout_of_format(std::uint32_t format) {
  switch (format) {
    case video::kGrey:
      return PixelLayout::kGrey;
    case video::kRgb24:
      return PixelLayout::kRgb;
    case video::kBgr24:
      return PixelLayout::kBgr;
    case video::kYuyv:
      return PixelLayout::kYuyv;
    case video::kUyvy:
      return PixelLayout::kUyvy;
    case video::kGrey16:
    case video::kDepth16:
      return PixelLayout::kLittle16;
    default:
      return std::nullopt;
  }
}

Result<void> PictureMaker::make(const VideoHead& head, std::span<const std::byte> frame, u16 mode,
                                CameraData& picture) {
  if (is_jpeg(head.format)) return from_jpeg(frame, mode, picture);
  const PixelView view{.layout = layout_of_format(head.format).value_or(PixelLayout::kGrey),
                       .size = {head.width, head.height},
                       .bytes = frame,
                       .line_bytes = head.line_bytes};
  if (!view.is_whole())
    return Error(Errc::kMalformed, "frame of " + std::to_string(frame.size()) +
                                       " bytes does not have the size given by the camera");
  if (!is_possible(head.format, mode)) return cannot(head.format, mode);
  if (mode == camera_mode::kJpeg) return to_jpeg(view, picture);
  if (std::size_t{head.width} * head.height * depth_of(mode) / 8 > kCameraBytesMax)
    return Error(Errc::kTooBig, "the picture exceeds the maximum size of a message");
  if (auto made = converter_.convert(view, *layout_of_mode(mode), picture.image); !made)
    return made;
  set_size(picture, view.size, mode);
  return {};
}

Result<void> PictureMaker::to_jpeg(const PixelView& view, CameraData& picture) {
  if (auto made = jpeg_.encode(view, quality_, kCameraBytesMax, picture.image); !made) return made;
  set_size(picture, view.size, camera_mode::kJpeg);
  picture.colorFilterId = static_cast<u32>(picture.image.size());
  return {};
}

Result<void> PictureMaker::pass_jpeg(std::span<const std::byte> frame, CameraData& picture) {
  const auto size = jpeg_size(frame);
  if (!size || frame.size() > kCameraBytesMax / 2 || !jpeg_.complete(frame, picture.image))
    return Error(Errc::kMalformed, "the frame is not a complete JPEG picture");
  set_size(picture, *size, camera_mode::kJpeg);
  picture.colorFilterId = static_cast<u32>(picture.image.size());
  return {};
}

Result<void> PictureMaker::from_jpeg(std::span<const std::byte> frame, u16 mode,
                                     CameraData& picture) {
  if (mode == camera_mode::kJpeg) return pass_jpeg(frame, picture);
  if (mode != camera_mode::kMono8 && mode != camera_mode::kRgb24 && mode != camera_mode::kYuv422)
    return cannot(video::kMjpeg, mode);
  const bool is_grey = mode == camera_mode::kMono8;
  const auto size = jpeg_.decode(frame, is_grey ? PixelLayout::kGrey : PixelLayout::kBgr,
                                 kCameraBytesMax, is_grey ? picture.image : bgr_);
  if (!size) return size.error();
  if (!is_grey) {
    const PixelView view{.layout = PixelLayout::kBgr, .size = *size, .bytes = bgr_};
    if (auto made = converter_.convert(view, *layout_of_mode(mode), picture.image); !made)
      return made;
  }
  set_size(picture, *size, mode);
  return {};
}

Result<void> PictureMaker::compress(const CameraData& from, CameraData& jpeg) {
  jpeg.recordingTime = from.recordingTime;
  const std::uint32_t format = from.mode == camera_mode::kMono8    ? video::kGrey
                               : from.mode == camera_mode::kRgb24  ? video::kRgb24
                               : from.mode == camera_mode::kYuv422 ? video::kUyvy
                               : from.mode == camera_mode::kJpeg   ? video::kJpeg
                                                                   : 0;
  if (format == 0)
    return Error(Errc::kInvalidArgument, "pictures of mode " + std::to_string(from.mode) +
                                             " cannot be compressed; use mono8, rgb24 or yuv422");
  return make({.format = format, .width = from.width, .height = from.height}, from.image,
              camera_mode::kJpeg, jpeg);
}

std::optional<int> brightness_of(const CameraData& picture, int part) {
  const auto layout = layout_of_mode(picture.mode);
  if (!layout || *layout == PixelLayout::kBig16) return std::nullopt;
  // The luma, or green, its main part.
  const int channel = *layout == PixelLayout::kGrey ? 0 : 1;
  const auto mean = mean_of({.layout = *layout,
                             .size = {picture.width.raw(), picture.height.raw()},
                             .bytes = picture.image},
                            channel, part);
  if (!mean) return std::nullopt;
  return static_cast<int>(*mean);
}

}  // namespace rack::device
