#include "components/vision/marker_finder.h"

#include <algorithm>

namespace rack::vision {

namespace {

// A wrong identity puts a robot elsewhere: of the codes that are repaired, only those with few
// wrong bits, and only those with a clear contrast, are accepted.
constexpr int kWrongBitsMax = 1;  // none in a family whose codes are short
constexpr float kMarginMin = 20;
constexpr int kSmallestSide = 8;  // pixels

}  // namespace

MarkerFinder::MarkerFinder(const std::set<Family>& families)
    : detector_(apriltag_detector_create(), apriltag_detector_destroy) {
  detector_->nthreads = 1;
  detector_->quad_decimate = 1;
  for (const Family family : families) {
    families_.push_back({family, make_tag_family(family)});
    apriltag_detector_add_family_bits(detector_.get(), families_.back().tags.get(),
                                      family == Family::kTag16h5 ? 0 : kWrongBitsMax);
  }
}

tims::Result<std::vector<Sighting>> MarkerFinder::find(const GreyView& picture) {
  if (!picture.is_whole())
    return tims::Error(tims::Errc::kMalformed, "the picture has fewer pixels than its size");
  std::vector<Sighting> found;
  if (std::min(picture.width, picture.height) < kSmallestSide) return found;
  image_u8_t image{.width = picture.width,
                   .height = picture.height,
                   .stride = picture.width,
                   .buf = const_cast<std::uint8_t*>(picture.pixels.data())};
  zarray_t* const detections = apriltag_detector_detect(detector_.get(), &image);
  for (int i = 0; i < zarray_size(detections); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(detections, i, &detection);
    if (detection->decision_margin >= kMarginMin) found.push_back(sighting(*detection));
  }
  apriltag_detections_destroy(detections);
  return found;
}

Sighting MarkerFinder::sighting(const apriltag_detection& detection) const {
  const auto member = std::ranges::find_if(
      families_, [&](const Member& m) { return m.tags.get() == detection.family; });
  Sighting seen{.family = member->family, .id = detection.id};
  // The library's begin at the bottom left and go counter-clockwise.
  constexpr std::array<std::size_t, 4> kOrder = {3, 2, 1, 0};
  for (std::size_t i = 0; i < kOrder.size(); ++i)
    seen.corners.at(i) = {detection.p[kOrder.at(i)][0], detection.p[kOrder.at(i)][1]};
  return seen;
}

}  // namespace rack::vision
