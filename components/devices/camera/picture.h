// Converts frames of V4L2 and IIDC cameras to pictures of the modes of the camera class.
//
// 16 bit values are big-endian, as those of the IEEE 1394 cameras for which the class was designed;
// rgb24 is B G R, yuv422 is U Y0 V Y1. The raw modes have one colour per pixel; colorFilterId
// states which one. mono12 and raw12 are 12 of 16 bits.
#pragma once

#include <optional>
#include <string_view>

#include "components/devices/core/video_frame.h"
#include "components/pictures/jpeg.h"
#include "components/pictures/pixels.h"
#include "rack/proxies/camera.h"

namespace rack::device {

// Mode by the name used in CameraV4l and CameraDcam, for example "rgb24". Empty for unknown names.
std::optional<u16> mode_of(std::string_view name);
std::string_view name_of_mode(u16 mode);
// Bits per pixel; 0 for JPEG and unknown modes.
u16 depth_of(u16 mode);
// The pixels of pictures of a mode; empty for JPEG, raw8 and others.
constexpr std::optional<pictures::PixelLayout> layout_of_mode(u16 mode) {
  switch (mode) {
    case camera_mode::kMono8:
      return pictures::PixelLayout::kGrey;
    case camera_mode::kRgb24:
      return pictures::PixelLayout::kBgr;
    case camera_mode::kYuv422:
      return pictures::PixelLayout::kUyvy;
    case camera_mode::kMono12:
    case camera_mode::kMono16:
    case camera_mode::kRaw12:
    case camera_mode::kRaw16:
    case camera_mode::kRange:
      return pictures::PixelLayout::kBig16;
    default:
      return std::nullopt;
  }
}
// V4L2 formats that can be converted to this mode, cheapest first: "MJPG,YUYV".
std::string_view formats_for(u16 mode);
// V4L2 formats as layouts of pixels; empty for JPEG and unknown formats.
std::optional<pictures::PixelLayout> layout_of_format(std::uint32_t format);
constexpr bool is_jpeg(std::uint32_t format) {
  return format == video::kMjpeg || format == video::kJpeg;
}

// Keeps its buffers between pictures: only OpenCV allocates memory, for a picture of JPEG that it
// decodes or encodes.
class PictureMaker {
 public:
  // `quality`: quality of JPEG compressed here.
  explicit PictureMaker(int quality = 75) : quality_(quality) {}

  // Converts `frame` with the layout of `head` to a picture of `mode`; does not change
  // recordingTime. The error states why the conversion is not possible. `thinning`: see thinned();
  // JPEG frames are not thinned.
  tims::Result<void> make(const VideoHead& head, std::span<const std::byte> frame, u16 mode,
                          CameraData& picture, int thinning = 1);
  // Compresses a picture of mono8, rgb24 or yuv422 to JPEG.
  tims::Result<void> compress(const CameraData& from, CameraData& jpeg);

 private:
  tims::Result<void> from_jpeg(std::span<const std::byte> frame, u16 mode, CameraData& picture);
  tims::Result<void> pass_jpeg(std::span<const std::byte> frame, CameraData& picture);
  tims::Result<void> to_jpeg(const pictures::PixelView& view, CameraData& picture);

  int quality_;
  pictures::Jpeg jpeg_;
  pictures::PixelConverter converter_;
  std::vector<std::byte> bgr_;
  std::vector<std::byte> thinned_;
};

// The frame of a camera as pixels; empty for JPEG and unknown formats.
std::optional<pictures::PixelView> pixels_of(const VideoHead& head,
                                             std::span<const std::byte> frame);
// The picture as pixels that show something to people: mono8, mono16, rgb24 or yuv422; empty for
// other modes.
std::optional<pictures::PixelView> pixels_of(const CameraData& picture);

// Mean brightness, 0 to 255, of the middle 1/`part` of each side. Empty for modes without
// brightness.
std::optional<int> brightness_of(const CameraData& picture, int part);

}  // namespace rack::device
