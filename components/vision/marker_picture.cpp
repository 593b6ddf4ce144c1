#include "components/vision/marker_picture.h"

#include <memory>

#include <fmt/core.h>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>

#include "components/vision/tag_family.h"
#include "components/pictures/opencv_call.h"

namespace rack::vision {

namespace {

tims::Result<MarkerPicture> tag(const Marker& marker) {
  if (marker.id < 0 || marker.id >= ids_of(marker.family))
    return tims::Error(tims::Errc::kInvalidArgument,
                       fmt::format("{} has the markers 0 to {}, not {}", name_of(marker.family),
                                   ids_of(marker.family) - 1, marker.id));
  const TagFamily family = make_tag_family(marker.family);
  const std::unique_ptr<image_u8_t, void (*)(image_u8_t*)> image(
      apriltag_to_image(family.get(), static_cast<std::uint32_t>(marker.id)), image_u8_destroy);
  MarkerPicture picture{.side = image->width,
                        .whole = static_cast<double>(image->width) / family->width_at_border};
  for (int y = 0; y < image->height; ++y) {
    const std::uint8_t* const row = image->buf + y * image->stride;
    picture.cells.insert(picture.cells.end(), row, row + image->width);
  }
  return picture;
}

tims::Result<MarkerPicture> qr_code(const Marker& marker) {
  if (marker.text.empty())
    return tims::Error(tims::Errc::kInvalidArgument, "a QR code needs a text");
  cv::Mat code;
  const auto made = pictures::call_opencv("drawing a QR code", [&] {
    cv::QRCodeEncoder::create()->encode(marker.text, code);
  });
  if (!made) return tims::Error(tims::Errc::kInvalidArgument, made.error().detail());
  constexpr int kQuiet = 4;  // cells, as ISO/IEC 18004 requires
  // OpenCV draws a border of its own, which is not of that width.
  cv::Rect ink = cv::boundingRect(code == 0);
  MarkerPicture picture;
  picture.side = ink.width + 2 * kQuiet;
  picture.whole = static_cast<double>(picture.side) / ink.width;
  picture.cells.assign(static_cast<std::size_t>(picture.side * picture.side), 255);
  for (int y = 0; y < ink.height; ++y)
    for (int x = 0; x < ink.width; ++x)
      picture.cells[static_cast<std::size_t>((y + kQuiet) * picture.side + x + kQuiet)] =
          code.at<std::uint8_t>(ink.y + y, ink.x + x);
  return picture;
}

}  // namespace

tims::Result<MarkerPicture> picture_of(const Marker& marker) {
  return marker.family == Family::kQr ? qr_code(marker) : tag(marker);
}

}  // namespace rack::vision
