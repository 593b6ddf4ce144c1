// Rectifies the frames of a camera (components/pictures/rectifier.h) before they are converted to
// pictures of a mode.
//
// JPEG is decoded for it. Two pixels of YUYV and UYVY share their colours: luma and colours are
// rectified separately, the colours as a picture of half the width. Depths are not rectified,
// because a mean of the depths of two objects is the depth of none; depth cameras and stereo
// cameras do this themselves.
#pragma once

#include <optional>
#include <vector>

#include "components/devices/camera/picture.h"
#include "components/devices/core/video_frame.h"
#include "components/pictures/jpeg.h"
#include "components/pictures/pixels.h"
#include "components/pictures/rectifier.h"

namespace rack::device {

// Whether pictures of this mode can be rectified.
constexpr bool can_rectify(u16 mode) {
  return mode != camera_mode::kRange && mode != camera_mode::kDisparity &&
         mode != camera_mode::kRaw8 && mode != camera_mode::kRaw12 && mode != camera_mode::kRaw16;
}

class FrameRectifier {
 public:
  explicit FrameRectifier(pictures::CameraCalibration calibration)
      : calibration_(std::move(calibration)) {}

  struct Frame {
    VideoHead head{};
    std::span<const std::byte> bytes{};  // valid until the next call
  };
  // A frame that can be converted to `mode` like the given one. kInvalidArgument: the calibration
  // is for pictures of another aspect ratio, or the mode cannot be rectified.
  tims::Result<Frame> rectify(const VideoHead& head, std::span<const std::byte> frame, u16 mode);

 private:
  tims::Result<void> prepare(pictures::PictureSize size);
  tims::Result<Frame> rectify_plain(const pictures::PixelView& view, std::uint32_t format);
  tims::Result<Frame> rectify_numbers(const pictures::PixelView& view, std::uint32_t format);
  tims::Result<Frame> rectify_pairs(const pictures::PixelView& view, const VideoHead& head,
                                    u16 mode);

  pictures::CameraCalibration calibration_;
  pictures::PictureSize size_{};  // of the pictures for which the rectifiers were made
  std::optional<pictures::Rectifier> rectifier_;
  std::optional<pictures::Rectifier> colours_;  // for half the width
  pictures::Jpeg jpeg_;
  pictures::PixelConverter converter_;
  std::vector<std::byte> decoded_;
  std::vector<std::byte> luma_, rectified_luma_;
  std::vector<std::byte> colour_, rectified_colour_;  // U V of each pair
  std::vector<std::byte> made_;
};

}  // namespace rack::device
