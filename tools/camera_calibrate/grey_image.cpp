#include "tools/camera_calibrate/grey_image.h"

#include <algorithm>
#include <limits>
#include <span>
#include <string>

#include "components/devices/camera/picture.h"
#include "components/pictures/grey_picture.h"
#include "components/pictures/jpeg.h"
#include "components/pictures/png_file.h"

namespace rack::camera_calibrate {
namespace {

using pictures::PixelLayout;
using tims::Errc;
using tims::Error;
using tims::Result;

Result<GreyImage> of_jpeg(std::span<const std::byte> bytes) {
  GreyImage image;
  pictures::Jpeg jpeg;
  const auto size = jpeg.decode(bytes, PixelLayout::kGrey,
                                static_cast<std::size_t>(pictures::kGreyPixelsMax), image.pixels);
  if (!size) return size.error();
  image.width = static_cast<int>(size->width);
  image.height = static_cast<int>(size->height);
  return image;
}

// Motion JPEG may lack tables.
Result<GreyImage> of_frame(std::span<const std::byte> frame) {
  std::vector<std::byte> whole;
  if (!pictures::Jpeg().complete(frame, whole))
    return Error(Errc::kMalformed, "the picture is not a complete JPEG picture");
  return of_jpeg(whole);
}

// Big-endian. Cameras use a part of the range only: the picture is stretched.
Result<GreyImage> of_words(const CameraData& picture) {
  const std::size_t pixels = std::size_t{picture.width.raw()} * picture.height.raw();
  if (picture.image.size() < 2 * pixels)
    return Error(Errc::kMalformed, "the picture has fewer bytes than its size requires");
  const auto word = [&](std::size_t i) {
    return std::to_integer<int>(picture.image[2 * i]) << 8 |
           std::to_integer<int>(picture.image[2 * i + 1]);
  };
  int darkest = std::numeric_limits<int>::max();
  int brightest = 0;
  for (std::size_t i = 0; i < pixels; ++i) {
    darkest = std::min(darkest, word(i));
    brightest = std::max(brightest, word(i));
  }
  GreyImage image{.width = picture.width.raw(), .height = picture.height.raw()};
  image.pixels.resize(pixels);
  const int range = std::max(brightest - darkest, 1);
  for (std::size_t i = 0; i < pixels; ++i)
    image.pixels[i] = static_cast<std::byte>(255 * (word(i) - darkest) / range);
  return image;
}

}  // namespace

Result<GreyImage> grey_of_file(std::string_view bytes) {
  if (bytes.starts_with("\xFF\xD8")) return of_jpeg(std::as_bytes(std::span(bytes)));
  const auto picture = pictures::read_grey(bytes);
  if (!picture) {
    if (!bytes.starts_with("\x89PNG") && !bytes.starts_with('P'))
      return Error(Errc::kMalformed, "not a PNG, PGM or JPEG picture");
    return picture.error();
  }
  GreyImage image{.width = picture->width, .height = picture->height};
  image.pixels.reserve(picture->values.size());
  const int white = picture->white;
  for (const std::uint16_t value : picture->values)
    image.pixels.push_back(static_cast<std::byte>(std::min(value * 255 / white, 255)));
  return image;
}

Result<GreyImage> grey_of(const CameraData& picture) {
  if (picture.width.raw() == 0 || picture.height.raw() == 0)
    return Error(Errc::kMalformed, "the picture has no size");
  if (picture.mode == camera_mode::kJpeg) return of_frame(picture.image);
  if (picture.mode == camera_mode::kMono16) return of_words(picture);
  const auto pixels = device::pixels_of(picture);
  if (!pixels)
    return Error(Errc::kInvalidArgument,
                 "pictures of mode " + std::to_string(picture.mode) +
                     " show no board: set mode to mono8, mono16, rgb24, yuv422 or jpeg");
  GreyImage image{.width = picture.width.raw(), .height = picture.height.raw()};
  pictures::PixelConverter converter;
  if (auto done = converter.convert(*pixels, PixelLayout::kGrey, image.pixels); !done)
    return done.error();
  return image;
}

Result<std::string> png_of(const GreyImage& image) {
  const auto png =
      pictures::encode_png({.pixels = {.layout = PixelLayout::kGrey,
                                       .size = {static_cast<std::uint32_t>(image.width),
                                                static_cast<std::uint32_t>(image.height)},
                                       .bytes = image.pixels}});
  if (!png) return png.error();
  return std::string(reinterpret_cast<const char*>(png->data()), png->size());
}

}  // namespace rack::camera_calibrate
