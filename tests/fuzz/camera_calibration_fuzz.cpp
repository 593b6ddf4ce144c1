// Any calibration file is refused with a reason, or yields a calibration that is the same after it
// was written and read again, and that rectifies a picture.
#include <vector>

#include "components/pictures/camera_calibration.h"
#include "components/pictures/rectifier.h"
#include "tests/fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using tims::fuzz::require;
  namespace pictures = rack::pictures;
  const auto calibration = pictures::read_calibration(tims::fuzz::Input(data, size).text());
  if (!calibration) {
    require(!calibration.error().detail().empty());
    return 0;
  }
  const auto again = pictures::read_calibration(pictures::to_yaml(*calibration, "a\nremark"));
  require(again.ok() && *again == *calibration);
  const auto same =
      pictures::calibration_for(*calibration, calibration->width, calibration->height);
  require(same.ok() && same->width == calibration->width);
  constexpr int kWidth = 32;
  constexpr int kHeight = 24;
  const auto rectifier = pictures::Rectifier::make(pictures::scaled(*calibration, kWidth, kHeight));
  require(rectifier.ok());
  const std::vector<std::byte> picture(std::size_t{3} * kWidth * kHeight, std::byte{1});
  std::vector<std::byte> rectified(picture.size());
  require(rectifier->rectify({.bytes = picture, .channels = 3}, rectified).ok());
  for (const std::byte value : rectified) require(value <= std::byte{1});
  return 0;
}
