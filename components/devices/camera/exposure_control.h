// Exposure by shutter and gain, as CameraDcam of the original controls it.
//
// The share of dark pixels minus the share of bright pixels, -1 to 1, is multiplied with a factor
// and added to the shutter, or to the gain. Gain adds noise: a picture is made brighter by the
// shutter until that is at its maximum, and darker by the gain until that is at its minimum.
#pragma once

#include "components/devices/camera/frame_control.h"

namespace rack::device {

struct ExposureSettings {
  int dark_max = 60;     // pixels up to this value are dark
  int bright_min = 250;  // pixels from this value on are bright
  int gain_factor = 16;
  int shutter_factor = 64;
  int part = 1;  // evaluated are the lowest 1/part of the lines; 0: no control
  // Used if there is no control. -1: by the camera.
  int shutter = -1;
  int gain = -1;
};

class ExposureControl final : public FrameControl {
 public:
  explicit ExposureControl(const ExposureSettings& settings) : settings_(settings) {}

  void start() override;
  void on_control(const VideoControl& control, Output& out) override;
  void on_frame(const pictures::PixelView& frame, Output& out) override;

 private:
  static void change(VideoControl& control, double by, Output& out);

  ExposureSettings settings_;
  VideoControl shutter_{};  // id 0: the camera has no such control
  VideoControl gain_{};
};

}  // namespace rack::device
