// What sets the controls of a camera by its frames: exposure, white balance. It evaluates the
// frames as the camera sends them, so that the mode of the pictures does not matter.
#pragma once

#include "components/devices/core/video_frame.h"
#include "components/pictures/pixels.h"
#include "rack/devices/dialogue.h"

namespace rack::device {

class FrameControl {
 public:
  virtual ~FrameControl() = default;
  // The camera was opened: forgets its controls.
  virtual void start() = 0;
  // The camera has this control. All controls are reported before the first frame.
  virtual void on_control(const VideoControl& control, Output& out) = 0;
  virtual void on_frame(const pictures::PixelView& frame, Output& out) = 0;
};

}  // namespace rack::device
