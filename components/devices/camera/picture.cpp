#include "components/devices/camera/picture.h"

#include <algorithm>
#include <array>
#include <cstring>
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

bool is_jpeg(std::uint32_t format) { return format == video::kMjpeg || format == video::kJpeg; }
bool is_yuv(std::uint32_t format) { return format == video::kYuyv || format == video::kUyvy; }
bool is_rgb(std::uint32_t format) { return format == video::kRgb24 || format == video::kBgr24; }

std::size_t bytes_of_pixel(std::uint32_t format) {
  if (is_rgb(format)) return 3;
  return format == video::kGrey ? 1 : 2;
}

std::byte clamped(int value) { return static_cast<std::byte>(std::clamp(value, 0, 255)); }

// The lines of a frame without padding.
class Lines {
 public:
  Lines(const VideoHead& head, std::span<const std::byte> frame)
      : frame_(frame),
        used_(head.width * bytes_of_pixel(head.format)),
        stride_(std::max<std::size_t>(used_, head.line_bytes)) {}
  [[nodiscard]] bool are_whole(std::uint32_t height) const {
    return used_ > 0 && height > 0 && frame_.size() >= stride_ * (height - 1) + used_;
  }
  [[nodiscard]] std::span<const std::byte> line(std::uint32_t y) const {
    return frame_.subspan(y * stride_, used_);
  }

 private:
  std::span<const std::byte> frame_;
  std::size_t used_;
  std::size_t stride_;
};

int value(std::byte byte) { return std::to_integer<int>(byte); }

// Conversion by ITU-R BT.601 with limited range, in units of 1/256. Two pixels share one colour.
template <std::size_t kLuma>
void rgb_of_yuv(std::span<const std::byte> line, std::byte* out) {
  constexpr std::size_t kColour = 1 - kLuma;
  for (std::size_t i = 0; i + 3 < line.size(); i += 4, out += 6) {
    const int blue = value(line[i + kColour]) - 128;
    const int red = value(line[i + kColour + 2]) - 128;
    const int of_red = 409 * red;
    const int of_green = -100 * blue - 208 * red;
    const int of_blue = 516 * blue;
    const int first = 298 * (value(line[i + kLuma]) - 16) + 128;
    const int second = 298 * (value(line[i + kLuma + 2]) - 16) + 128;
    out[0] = clamped((first + of_red) >> 8);
    out[1] = clamped((first + of_green) >> 8);
    out[2] = clamped((first + of_blue) >> 8);
    out[3] = clamped((second + of_red) >> 8);
    out[4] = clamped((second + of_green) >> 8);
    out[5] = clamped((second + of_blue) >> 8);
  }
}

void grey_line(std::uint32_t format, std::span<const std::byte> line, std::byte* out) {
  if (format == video::kGrey) {
    std::ranges::copy(line, out);
  } else if (is_yuv(format)) {
    const std::size_t first = format == video::kYuyv ? 0 : 1;
    for (std::size_t i = first; i < line.size(); i += 2) *out++ = line[i];
  } else {
    const std::size_t red = format == video::kRgb24 ? 0 : 2;
    for (std::size_t i = 0; i + 2 < line.size(); i += 3)
      *out++ = static_cast<std::byte>(
          (77 * value(line[i + red]) + 150 * value(line[i + 1]) + 29 * value(line[i + 2 - red])) >>
          8);
  }
}

void rgb_line(std::uint32_t format, std::span<const std::byte> line, std::byte* out) {
  if (format == video::kRgb24) {
    std::ranges::copy(line, out);
  } else if (format == video::kBgr24) {
    for (std::size_t i = 0; i + 2 < line.size(); i += 3)
      for (const std::size_t from : {i + 2, i + 1, i}) *out++ = line[from];
  } else if (format == video::kYuyv) {
    rgb_of_yuv<0>(line, out);
  } else if (format == video::kUyvy) {
    rgb_of_yuv<1>(line, out);
  } else {
    for (const std::byte grey : line)
      for (int i = 0; i < 3; ++i) *out++ = grey;
  }
}

// Swaps each pair of bytes.
void swapped_line(std::span<const std::byte> line, std::byte* out) {
  for (std::size_t i = 0; i + 1 < line.size(); i += 2) {
    *out++ = line[i + 1];
    *out++ = line[i];
  }
}

using LineOf = void (*)(std::uint32_t, std::span<const std::byte>, std::byte*);

// The function that converts a line of this format to this mode; null if there is none.
LineOf line_for(std::uint32_t format, u16 mode) {
  const auto copy = [](std::uint32_t, std::span<const std::byte> line, std::byte* out) {
    std::ranges::copy(line, out);
  };
  const auto swap = [](std::uint32_t, std::span<const std::byte> line, std::byte* out) {
    swapped_line(line, out);
  };
  const bool is_colour = is_yuv(format) || is_rgb(format);
  if (mode == camera_mode::kMono8 && (is_colour || format == video::kGrey)) return grey_line;
  if (mode == camera_mode::kRgb24 && (is_colour || format == video::kGrey)) return rgb_line;
  if (mode == camera_mode::kYuv422 && format == video::kUyvy) return copy;
  if (mode == camera_mode::kYuv422 && format == video::kYuyv) return swap;
  if (mode == camera_mode::kMono16 && format == video::kGrey16) return swap;
  if (mode == camera_mode::kRange && format == video::kDepth16) return swap;
  return nullptr;
}

void set_size(CameraData& picture, PictureSize size, u16 mode) {
  picture.width = static_cast<u16>(size.width);
  picture.height = static_cast<u16>(size.height);
  picture.depth = depth_of(mode);
  picture.mode = mode;
  picture.colorFilterId = 0;
}

// Two pixels share the mean of their U and V.
void yuv422_of(std::span<const std::byte> yuv444, std::vector<std::byte>& out) {
  out.resize(yuv444.size() / 6 * 4);
  for (std::size_t from = 0, to = 0; from + 5 < yuv444.size(); from += 6, to += 4) {
    out[to] = static_cast<std::byte>((value(yuv444[from + 1]) + value(yuv444[from + 4])) / 2);
    out[to + 1] = yuv444[from];
    out[to + 2] = static_cast<std::byte>((value(yuv444[from + 2]) + value(yuv444[from + 5])) / 2);
    out[to + 3] = yuv444[from + 3];
  }
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

Result<void> PictureMaker::make(const VideoHead& head, std::span<const std::byte> frame, u16 mode,
                                CameraData& picture) {
  if (is_jpeg(head.format)) return from_jpeg(frame, mode, picture);
  const PictureSize size{head.width, head.height};
  const Lines lines(head, frame);
  if (size.width > 0xFFFF || size.height > 0xFFFF || !lines.are_whole(size.height))
    return Error(Errc::kMalformed, "frame of " + std::to_string(frame.size()) +
                                       " bytes does not have the size given by the camera");
  const bool is_to_jpeg = mode == camera_mode::kJpeg;
  const LineOf line_of = line_for(head.format, is_to_jpeg ? camera_mode::kRgb24 : mode);
  if (line_of == nullptr) return cannot(head.format, mode);
  if (is_to_jpeg) return to_jpeg(grey_or_rgb(head, frame), picture);
  const std::size_t line_bytes = std::size_t{size.width} * depth_of(mode) / 8;
  if (line_bytes * size.height > kCameraBytesMax)
    return Error(Errc::kTooBig, "the picture exceeds the maximum size of a message");
  picture.image.resize(line_bytes * size.height);
  for (std::uint32_t y = 0; y < size.height; ++y)
    line_of(head.format, lines.line(y), picture.image.data() + y * line_bytes);
  set_size(picture, size, mode);
  return {};
}

PixelView PictureMaker::grey_or_rgb(const VideoHead& head, std::span<const std::byte> frame) {
  const bool is_grey = head.format == video::kGrey;
  const std::size_t line_bytes = std::size_t{head.width} * (is_grey ? 1 : 3);
  const Lines lines(head, frame);
  pixels_.resize(line_bytes * head.height);
  for (std::uint32_t y = 0; y < head.height; ++y)
    (is_grey ? grey_line : rgb_line)(head.format, lines.line(y), pixels_.data() + y * line_bytes);
  return {.format = is_grey ? Pixels8::kGrey : Pixels8::kRgb,
          .size = {head.width, head.height},
          .bytes = pixels_};
}

Result<void> PictureMaker::to_jpeg(const PixelView& view, CameraData& picture) {
  if (auto made = jpeg_.encode(view, quality_, kCameraBytesMax, picture.image); !made) return made;
  set_size(picture, view.size, camera_mode::kJpeg);
  picture.colorFilterId = static_cast<u32>(picture.image.size());
  return {};
}

Result<void> PictureMaker::from_jpeg(std::span<const std::byte> frame, u16 mode,
                                     CameraData& picture) {
  if (mode == camera_mode::kJpeg) {
    const auto size = jpeg_size(frame);
    if (!size || frame.size() > kCameraBytesMax / 2 || !jpeg_.complete(frame, picture.image))
      return Error(Errc::kMalformed, "the frame is not a complete JPEG picture");
    set_size(picture, *size, mode);
    picture.colorFilterId = static_cast<u32>(picture.image.size());
    return {};
  }
  if (mode != camera_mode::kMono8 && mode != camera_mode::kRgb24 && mode != camera_mode::kYuv422)
    return cannot(video::kMjpeg, mode);
  const bool is_yuv422 = mode == camera_mode::kYuv422;
  std::vector<std::byte>& out = is_yuv422 ? pixels_ : picture.image;
  const Pixels8 format = is_yuv422                     ? Pixels8::kYuv444
                         : mode == camera_mode::kRgb24 ? Pixels8::kRgb
                                                       : Pixels8::kGrey;
  const auto size = jpeg_.decode(frame, format, kCameraBytesMax, out);
  if (!size) return size.error();
  if (is_yuv422 && size->width % 2 != 0) return cannot(video::kMjpeg, mode);
  if (is_yuv422) yuv422_of(pixels_, picture.image);
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
  const std::size_t step = picture.mode == camera_mode::kMono8    ? 1
                           : picture.mode == camera_mode::kYuv422 ? 2
                           : picture.mode == camera_mode::kRgb24  ? 3
                                                                  : 0;
  const std::size_t width = picture.width;
  const std::size_t height = picture.height;
  if (step == 0 || part < 1 || width == 0 || height == 0 ||
      picture.image.size() < width * height * step)
    return std::nullopt;
  // Uses the luma, or green, its main part; some thousand pixels suffice.
  const std::size_t in_pixel = step == 1 ? 0 : 1;
  const auto divisor = static_cast<std::size_t>(part);
  const std::size_t w = std::max<std::size_t>(1, width / divisor);
  const std::size_t h = std::max<std::size_t>(1, height / divisor);
  const std::size_t every = 1 + std::max(w, h) / 64;
  std::size_t sum = 0;
  std::size_t count = 0;
  for (std::size_t y = (height - h) / 2; y < (height + h) / 2; y += every)
    for (std::size_t x = (width - w) / 2; x < (width + w) / 2; x += every, ++count)
      sum += std::to_integer<std::size_t>(picture.image[(y * width + x) * step + in_pixel]);
  if (count == 0) return std::nullopt;
  return static_cast<int>(sum / count);
}

}  // namespace rack::device
