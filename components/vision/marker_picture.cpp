#include "components/vision/marker_picture.h"

#include <memory>

#include <fmt/core.h>

#include "components/vision/tag_family.h"

namespace rack::vision {

tims::Result<MarkerPicture> picture_of(const Marker& marker) {
  if (marker.id < 0 || marker.id >= ids_of(marker.family))
    return tims::Error(tims::Errc::kInvalidArgument,
                       fmt::format("{} has the markers 0 to {}, not {}", name_of(marker.family),
                                   ids_of(marker.family) - 1, marker.id));
  const TagFamily family = make_tag_family(marker.family);
  const std::unique_ptr<image_u8_t, void (*)(image_u8_t*)> image(
      apriltag_to_image(family.get(), marker.id), image_u8_destroy);
  MarkerPicture picture{.side = image->width,
                        .whole = static_cast<double>(image->width) / family->width_at_border};
  for (int y = 0; y < image->height; ++y) {
    const std::uint8_t* const row = image->buf + y * image->stride;
    picture.cells.insert(picture.cells.end(), row, row + image->width);
  }
  return picture;
}

}  // namespace rack::vision
