#include "components/vision/grey_frame.h"

#include <optional>
#include <string>

namespace rack::vision {

namespace {

std::optional<device::PixelLayout> layout_of(u16 mode) {
  switch (mode) {
    case camera_mode::kMono8:
      return device::PixelLayout::kGrey;
    case camera_mode::kMono16:
      return device::PixelLayout::kBig16;
    case camera_mode::kRgb24:
      return device::PixelLayout::kRgb;
    case camera_mode::kYuv422:
      return device::PixelLayout::kUyvy;
    default:
      return std::nullopt;
  }
}

}  // namespace

tims::Result<GreyView> GreyFrame::take(const CameraData& picture) {
  constexpr std::size_t kBytesMax = kCameraBytesMax;
  const std::span<const std::byte> bytes(picture.image.data(), picture.image.size());
  device::PictureSize size{picture.width.raw(), picture.height.raw()};
  if (picture.mode == camera_mode::kJpeg) {
    const auto decoded = jpeg_.decode(bytes, device::PixelLayout::kGrey, kBytesMax, pixels_);
    if (!decoded) return decoded.error();
    size = *decoded;
  } else {
    const auto layout = layout_of(picture.mode);
    if (!layout)
      return tims::Error(tims::Errc::kInvalidArgument,
                         "the camera's mode " + std::to_string(picture.mode) +
                             " is not supported: use mono8, mono16, rgb24, yuv422 or jpeg");
    const device::PixelView view{.layout = *layout, .size = size, .bytes = bytes};
    if (auto done = converter_.convert(view, device::PixelLayout::kGrey, pixels_); !done)
      return done.error();
  }
  return GreyView{
      .width = static_cast<int>(size.width),
      .height = static_cast<int>(size.height),
      .pixels = {reinterpret_cast<const std::uint8_t*>(pixels_.data()), pixels_.size()}};
}

}  // namespace rack::vision
