// Removes the distortion of a lens from pictures, by OpenCV: straight edges become straight lines,
// and positions of pixels follow CameraCalibration::rectified.
//
// The place of each pixel in the camera's picture is computed once. Pixels that the camera did not
// see become `border`.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

#include "components/pictures/camera_calibration.h"
#include "tims/result.h"

namespace rack::pictures {

inline constexpr std::int64_t kRectifiedPixelsMax = 1 << 24;  // 6 bytes each are kept

struct Raster {
  std::span<const std::byte> bytes{};
  int channels = 1;            // 1 to 4
  int channel_bytes = 1;       // 1, or 2 in the byte order of this computer
  std::size_t line_bytes = 0;  // distance of lines; 0: without padding
  double border = 0;           // of each channel
};

class Rectifier {
 public:
  // For pictures of the size of the calibration: see calibration_for(). kTooBig: too many pixels.
  static tims::Result<Rectifier> make(const CameraCalibration& calibration);
  Rectifier(Rectifier&&) noexcept;
  Rectifier& operator=(Rectifier&&) noexcept;
  ~Rectifier();

  // `to`: as many bytes as the picture has, without padding; not the memory of `from`. kMalformed:
  // there are fewer bytes than the size requires.
  tims::Result<void> rectify(const Raster& from, std::span<std::byte> to) const;

 private:
  struct Places;
  explicit Rectifier(std::unique_ptr<Places> places);

  std::unique_ptr<Places> places_;
};

}  // namespace rack::pictures
