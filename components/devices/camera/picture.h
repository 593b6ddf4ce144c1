// Frames of cameras as pictures of the camera class: what modes each format of V4L2 can become.
//
// Words of 16 bits have their higher byte first, as those of IEEE 1394 cameras that the class was
// made for; rgb24 is R G B, yuv422 is U Y0 V Y1.
#pragma once

#include <optional>
#include <string_view>

#include "components/devices/camera/jpeg.h"
#include "components/devices/core/video_frame.h"
#include "rack/proxies/camera.h"

namespace rack::device {

// "rgb24": the names of CameraV4l's mode. Nothing: there is no such mode.
std::optional<u16> mode_of(std::string_view name);
std::string_view name_of_mode(u16 mode);
// Bits of a pixel; 0: of JPEG, and of what is not known here.
u16 depth_of(u16 mode);
// Formats of V4L2 that become this mode, the cheapest first: "MJPG,YUYV".
std::string_view formats_for(u16 mode);

// Holds what is needed between two pictures, so that nothing is allocated for each.
class PictureMaker {
 public:
  // `quality`: of JPEG that is made here.
  explicit PictureMaker(int quality = 75) : quality_(quality) {}

  // `frame` as `head` says, as a picture of `mode`; recordingTime is left as it is. An error says
  // why it cannot become one.
  tims::Result<void> make(const VideoHead& head, std::span<const std::byte> frame, u16 mode,
                          CameraData& picture);
  // A picture of mono8, rgb24 or yuv422 as JPEG.
  tims::Result<void> compress(const CameraData& from, CameraData& jpeg);

 private:
  tims::Result<void> from_jpeg(std::span<const std::byte> frame, u16 mode, CameraData& picture);
  tims::Result<void> to_jpeg(const PixelView& view, CameraData& picture);
  PixelView grey_or_rgb(const VideoHead& head, std::span<const std::byte> frame);

  int quality_;
  Jpeg jpeg_;
  std::vector<std::byte> pixels_;
};

// How bright it is, 0 to 255, in the middle: of each side one part in `part`. Nothing: of this mode
// it cannot be said.
std::optional<int> brightness_of(const CameraData& picture, int part);

}  // namespace rack::device
