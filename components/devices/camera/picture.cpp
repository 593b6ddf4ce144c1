#include "components/devices/camera/picture.h"

#include <algorithm>
#include <array>
#include <string>

namespace rack::device {
namespace {

using pictures::jpeg_size;
using pictures::PictureSize;
using pictures::PixelConverter;
using pictures::PixelLayout;
using pictures::PixelView;
using pictures::thinned;
using tims::Errc;
using tims::Error;
using tims::Result;

struct Mode {
  std::string_view name;
  u16 mode;
  u16 depth;
  std::string_view formats;
};

constexpr std::string_view kBayerFormats = "RGGB,GBRG,GRBG,BA81";
constexpr std::string_view kBayer16Formats = "RG16,GB16,GR16,BYR2";

constexpr std::array<Mode, 11> kModes = {{
    {"mono8", camera_mode::kMono8, 8, "GREY,YUYV,UYVY,MJPG,JPEG,RGB3,BGR3,RGGB,GBRG,GRBG,BA81"},
    {"mono12", camera_mode::kMono12, 16, "Y16"},
    {"mono16", camera_mode::kMono16, 16, "Y16"},
    {"rgb24", camera_mode::kRgb24, 24, "BGR3,RGB3,YUYV,UYVY,MJPG,JPEG,RGGB,GBRG,GRBG,BA81"},
    {"yuv422", camera_mode::kYuv422, 16, "UYVY,YUYV,MJPG,JPEG"},
    {"raw8", camera_mode::kRaw8, 8, kBayerFormats},
    {"raw12", camera_mode::kRaw12, 16, kBayer16Formats},
    {"raw16", camera_mode::kRaw16, 16, kBayer16Formats},
    {"jpeg", camera_mode::kJpeg, 24, "MJPG,JPEG,YUYV,UYVY,RGB3,BGR3,GREY,RGGB,GBRG,GRBG,BA81"},
    {"range", camera_mode::kRange, 16, "Z16,GREY,YUYV,UYVY,MJPG,JPEG"},
    {"disparity", camera_mode::kDisparity, 16, "GREY,YUYV,UYVY,MJPG,JPEG"},
}};

// Formats of cameras as layouts of pixels.
struct Format {
  std::uint32_t format;
  PixelLayout layout;
  u32 filter = 0;  // colorFilterId of the raw modes
};
constexpr std::array<Format, 15> kFormats = {{
    {video::kGrey, PixelLayout::kGrey},
    {video::kRgb24, PixelLayout::kRgb},
    {video::kBgr24, PixelLayout::kBgr},
    {video::kYuyv, PixelLayout::kYuyv},
    {video::kUyvy, PixelLayout::kUyvy},
    {video::kGrey16, PixelLayout::kLittle16},
    {video::kDepth16, PixelLayout::kLittle16},
    {video::kRggb, PixelLayout::kRggb, bayer::kRggb},
    {video::kGbrg, PixelLayout::kGbrg, bayer::kGbrg},
    {video::kGrbg, PixelLayout::kGrbg, bayer::kGrbg},
    {video::kBggr, PixelLayout::kBggr, bayer::kBggr},
    {video::kRggb16, PixelLayout::kLittle16, bayer::kRggb},
    {video::kGbrg16, PixelLayout::kLittle16, bayer::kGbrg},
    {video::kGrbg16, PixelLayout::kLittle16, bayer::kGrbg},
    {video::kBggr16, PixelLayout::kLittle16, bayer::kBggr},
}};

const Mode* find_mode(u16 mode) {
  const auto* const found = std::ranges::find(kModes, mode, &Mode::mode);
  return found == kModes.end() ? nullptr : found;
}

const Format* find_format(std::uint32_t format) {
  const auto* const found =
      std::ranges::find(kFormats, format & ~video::kBigEndian, &Format::format);
  return found == kFormats.end() ? nullptr : found;
}

bool is_raw(u16 mode) {
  return mode == camera_mode::kRaw8 || mode == camera_mode::kRaw12 || mode == camera_mode::kRaw16;
}

// The layout that frames of the format have in the mode. Numbers of 16 bits are grey values,
// colours or depths: none becomes the other.
std::optional<PixelLayout> target_of(std::uint32_t format, u16 mode) {
  const auto from = layout_of_format(format);
  if (!from) return std::nullopt;
  const bool is_big = *from == PixelLayout::kLittle16 || *from == PixelLayout::kBig16;
  const std::uint32_t base = format & ~video::kBigEndian;
  const bool has_filter = find_format(format)->filter != 0;
  if (is_raw(mode)) {
    if (!has_filter || is_big != (mode != camera_mode::kRaw8)) return std::nullopt;
    return is_big ? PixelLayout::kBig16 : *from;
  }
  if (is_big && has_filter) return std::nullopt;
  if (base == video::kGrey16 && mode != camera_mode::kMono16 && mode != camera_mode::kMono12)
    return std::nullopt;
  if (base == video::kDepth16 && mode != camera_mode::kRange) return std::nullopt;
  if (mode == camera_mode::kJpeg) return PixelLayout::kBgr;
  const auto to = layout_of_mode(mode);
  return to && PixelConverter::can_convert(*from, *to) ? to : std::nullopt;
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
  const Format* const found = find_format(format);
  if (found == nullptr) return std::nullopt;
  const bool is_big = (format & video::kBigEndian) != 0;
  if (!is_big) return found->layout;
  return found->layout == PixelLayout::kLittle16 ? std::optional(PixelLayout::kBig16)
                                                 : std::nullopt;
}

std::optional<PixelView> pixels_of(const VideoHead& head, std::span<const std::byte> frame) {
  const auto layout = layout_of_format(head.format);
  if (!layout) return std::nullopt;
  return PixelView{.layout = *layout,
                   .size = {head.width, head.height},
                   .bytes = frame,
                   .line_bytes = head.line_bytes};
}

std::optional<PixelView> pixels_of(const CameraData& picture) {
  const auto layout = layout_of_mode(picture.mode);
  if (!layout || (*layout == PixelLayout::kBig16 && picture.mode != camera_mode::kMono16))
    return std::nullopt;
  return PixelView{.layout = *layout,
                   .size = {picture.width.raw(), picture.height.raw()},
                   .bytes = picture.image};
}

Result<void> PictureMaker::make(const VideoHead& head, std::span<const std::byte> frame, u16 mode,
                                CameraData& picture, int thinning) {
  if (is_jpeg(head.format)) return from_jpeg(frame, mode, picture);
  const auto whole = pixels_of(head, frame);
  if (!whole) return cannot(head.format, mode);
  if (!whole->is_whole())
    return Error(Errc::kMalformed, "frame of " + std::to_string(frame.size()) +
                                       " bytes does not have the size given by the camera");
  const auto to = target_of(head.format, mode);
  if (!to) return cannot(head.format, mode);
  const u32 filter = find_format(head.format)->filter;
  const auto view = thinned(*whole, filter == 0 ? group_of(whole->layout) : PictureSize{2, 2},
                            thinning, thinned_);
  if (!view) return view.error();
  if (mode == camera_mode::kJpeg) return to_jpeg(*view, picture);
  if (std::uint64_t{view->size.width} * view->size.height * depth_of(mode) / 8 > kCameraBytesMax)
    return Error(Errc::kTooBig, "the picture exceeds the maximum size of a message");
  if (auto made = converter_.convert(*view, *to, picture.image); !made) return made;
  set_size(picture, view->size, mode);
  if (is_raw(mode)) picture.colorFilterId = filter;
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
  const bool is_decoded = is_grey || mode == camera_mode::kRgb24;  // without another conversion
  const auto size = jpeg_.decode(frame, is_grey ? PixelLayout::kGrey : PixelLayout::kBgr,
                                 kCameraBytesMax, is_decoded ? picture.image : bgr_);
  if (!size) return size.error();
  if (!is_decoded) {
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
                               : from.mode == camera_mode::kRgb24  ? video::kBgr24
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
  const auto pixels = pixels_of(picture);
  if (!pixels || pixels->layout == PixelLayout::kBig16) return std::nullopt;
  // The luma, or green, its main part.
  const int channel = pixels->layout == PixelLayout::kGrey ? 0 : 1;
  const auto mean = mean_of(*pixels, channel, part);
  if (!mean) return std::nullopt;
  return static_cast<int>(*mean);
}

}  // namespace rack::device
