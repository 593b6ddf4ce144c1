// Without OpenCV: Scan2d refuses a camera whose image needs it.
#include "components/scan2d/picture_intensity.h"

namespace rack::scan2d {
namespace {

tims::Error without_pictures() {
  return {tims::Errc::kInvalidArgument,
          "intensities of a camera's image: this Scan2d was built without OpenCV "
          "(-DRACK_WITH_OPENCV=ON)"};
}

}  // namespace

tims::Result<CameraView> CameraView::make(const CameraParamData&, const Pose&) {
  return without_pictures();
}

tims::Result<std::span<const std::optional<Pixel>>> CameraView::pixels(
    std::span<const scan3d::Place>, double, double) {
  return without_pictures();
}

tims::Result<void> CameraView::add_brightness(const CameraData&, const Pose&, Scan2dData&) {
  return without_pictures();
}

}  // namespace rack::scan2d
