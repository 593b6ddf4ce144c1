#include "components/vision/marker_finder.h"

#include <algorithm>

#include <opencv2/objdetect.hpp>

#include "components/pictures/opencv_call.h"
#include "components/vision/tag_family.h"

namespace rack::vision {

namespace {

// A wrong identity puts a robot elsewhere: of the codes that are repaired, only those with few
// wrong bits, and only those with a clear contrast, are accepted.
constexpr int kWrongBitsMax = 1;
constexpr float kMarginMin = 20;
constexpr int kSmallestSide = 8;  // pixels

cv::Mat mat_of(const GreyView& picture) {
  return {picture.height, picture.width, CV_8U, const_cast<std::uint8_t*>(picture.pixels.data())};
}

}  // namespace

// --- AprilTags

class MarkerFinder::Tags {
 public:
  Tags() : detector_(apriltag_detector_create(), apriltag_detector_destroy) {
    detector_->nthreads = 1;
    detector_->quad_decimate = 1;
  }

  void add(Family family) {
    families_.push_back({family, make_tag_family(family)});
    apriltag_detector_add_family_bits(detector_.get(), families_.back().tags.get(), kWrongBitsMax);
  }

  void find(const GreyView& picture, std::vector<Sighting>& found) {
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
  }

 private:
  struct Member {
    Family family;
    TagFamily tags;
  };

  [[nodiscard]] Sighting sighting(const apriltag_detection_t& detection) const {
    const auto member = std::ranges::find_if(
        families_, [&](const Member& m) { return m.tags.get() == detection.family; });
    Sighting seen{.family = member->family, .id = detection.id};
    // The library's begin at the bottom left and go counter-clockwise.
    constexpr std::array<std::size_t, 4> kOrder = {3, 2, 1, 0};
    for (std::size_t i = 0; i < kOrder.size(); ++i)
      seen.corners.at(i) = {detection.p[kOrder.at(i)][0], detection.p[kOrder.at(i)][1]};
    return seen;
  }

  std::vector<Member> families_;  // outlive the detector, which refers to them
  std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector_;
};

// --- QR codes

class MarkerFinder::Codes {
 public:
  tims::Result<void> find(const GreyView& picture, std::vector<Sighting>& found) {
    return pictures::call_opencv("finding QR codes", [&] {
      std::vector<std::string> texts;
      std::vector<cv::Point2f> corners;
      if (!detector_.detectAndDecodeMulti(mat_of(picture), texts, corners)) return;
      for (std::size_t i = 0; i < texts.size() && 4 * i + 3 < corners.size(); ++i) {
        if (texts[i].empty()) continue;  // found, and not read
        Sighting seen{.family = Family::kQr, .text = texts[i]};
        for (std::size_t k = 0; k < 4; ++k)
          seen.corners.at(k) = {corners[4 * i + k].x, corners[4 * i + k].y};
        found.push_back(std::move(seen));
      }
    });
  }

 private:
  cv::QRCodeDetector detector_;
};

// ---

MarkerFinder::MarkerFinder(const std::set<Family>& families) {
  for (const Family family : families) {
    if (family == Family::kQr) {
      codes_ = std::make_unique<Codes>();
    } else {
      if (!tags_) tags_ = std::make_unique<Tags>();
      tags_->add(family);
    }
  }
}

MarkerFinder::MarkerFinder(MarkerFinder&&) noexcept = default;
MarkerFinder& MarkerFinder::operator=(MarkerFinder&&) noexcept = default;
MarkerFinder::~MarkerFinder() = default;

tims::Result<std::vector<Sighting>> MarkerFinder::find(const GreyView& picture) {
  const auto pixels =
      static_cast<std::int64_t>(picture.width) * static_cast<std::int64_t>(picture.height);
  if (picture.width < 0 || picture.height < 0 ||
      static_cast<std::int64_t>(picture.pixels.size()) < pixels)
    return tims::Error(tims::Errc::kMalformed, "the picture has fewer pixels than its size");
  std::vector<Sighting> found;
  if (std::min(picture.width, picture.height) < kSmallestSide) return found;
  if (tags_) tags_->find(picture, found);
  if (codes_)
    if (auto done = codes_->find(picture, found); !done) return done.error();
  return found;
}

}  // namespace rack::vision
