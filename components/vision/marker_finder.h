// Finds markers in grey pictures: AprilTags by libapriltag, QR codes by OpenCV.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "components/vision/camera_geometry.h"
#include "components/vision/marker_map.h"
#include "tims/result.h"

namespace rack::vision {

struct GreyView {
  int width = 0;
  int height = 0;
  std::span<const std::uint8_t> pixels{};  // width * height
};

// A marker in the picture. Its corners are those of the black square, or of the whole QR code: top
// left, top right, bottom right, bottom left of the marker as it is printed.
struct Sighting {
  Family family = Family::kTag36h11;
  int id = 0;
  std::string text{};
  std::array<ImagePoint, 4> corners{};

  [[nodiscard]] bool shows(const Marker& marker) const {
    return family == marker.family && id == marker.id && text == marker.text;
  }
};

// Not thread-safe.
class MarkerFinder {
 public:
  explicit MarkerFinder(const std::set<Family>& families);
  MarkerFinder(MarkerFinder&&) noexcept;
  MarkerFinder& operator=(MarkerFinder&&) noexcept;
  ~MarkerFinder();

  // kMalformed: fewer pixels than the size requires, or an error of OpenCV.
  tims::Result<std::vector<Sighting>> find(const GreyView& picture);

 private:
  class Tags;
  class Codes;
  std::unique_ptr<Tags> tags_;    // null: none of their families
  std::unique_ptr<Codes> codes_;  // null: no QR codes
};

}  // namespace rack::vision
