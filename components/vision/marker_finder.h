// Finds AprilTags in grey pictures, by libapriltag.
#pragma once

#include <array>
#include <memory>
#include <set>
#include <vector>

#include "components/vision/camera_geometry.h"
#include "components/vision/grey_view.h"
#include "components/vision/marker_map.h"
#include "components/vision/tag_family.h"
#include "tims/result.h"

namespace rack::vision {

// A marker in the picture. Its corners are those of the black square: top left, top right, bottom
// right, bottom left of the marker as it is printed.
struct Sighting {
  Family family = Family::kTag36h11;
  int id = 0;
  std::array<ImagePoint, 4> corners{};

  [[nodiscard]] bool shows(const Marker& marker) const {
    return family == marker.family && id == marker.id;
  }
};

// Not thread-safe.
class MarkerFinder {
 public:
  explicit MarkerFinder(const std::set<Family>& families);

  // kMalformed: fewer pixels than the size requires.
  tims::Result<std::vector<Sighting>> find(const GreyView& picture);

 private:
  using Detector = std::unique_ptr<apriltag_detector, void (*)(apriltag_detector*)>;
  struct Member {
    Family family;
    TagFamily tags;
  };

  [[nodiscard]] Sighting sighting(const apriltag_detection& detection) const;

  std::vector<Member> families_;  // outlive the detector, which refers to them
  Detector detector_;
};

}  // namespace rack::vision
