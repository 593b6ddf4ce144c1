#include "components/vision/grey_frame.h"

#include <string>

#include "components/devices/camera/picture.h"

namespace rack::vision {

tims::Result<GreyView> GreyFrame::take(const CameraData& picture) {
  constexpr std::size_t kBytesMax = kCameraBytesMax;
  pictures::PictureSize size{picture.width.raw(), picture.height.raw()};
  if (picture.mode == camera_mode::kJpeg) {
    const auto decoded =
        jpeg_.decode(picture.image, pictures::PixelLayout::kGrey, kBytesMax, pixels_);
    if (!decoded) return decoded.error();
    size = *decoded;
  } else {
    const auto pixels = device::pixels_of(picture);
    if (!pixels)
      return tims::Error(tims::Errc::kInvalidArgument,
                         "the camera's mode " + std::to_string(picture.mode) +
                             " is not supported: use mono8, mono16, rgb24, yuv422 or jpeg");
    if (auto done = converter_.convert(*pixels, pictures::PixelLayout::kGrey, pixels_); !done)
      return done.error();
  }
  return GreyView{
      .width = static_cast<int>(size.width),
      .height = static_cast<int>(size.height),
      .pixels = {reinterpret_cast<const std::uint8_t*>(pixels_.data()), pixels_.size()}};
}

}  // namespace rack::vision
