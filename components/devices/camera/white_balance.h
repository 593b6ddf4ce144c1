// White balance by a grey surface in the picture, as CameraDcam of the original controls it.
//
// The surface is at the upper edge, in the middle: for example a card in front of the lens. Its
// mean colour differences should be 0 (128 in the frame); the camera's blue and red are changed by
// half of the deviation. Only YUYV and UYVY frames are evaluated.
#pragma once

#include "components/devices/camera/frame_control.h"

namespace rack::device {

enum class WhiteBalance : std::uint8_t { kFixed, kBySurface, kByCamera };

struct WhiteBalanceSettings {
  WhiteBalance method = WhiteBalance::kBySurface;
  int blue = 150;  // initial values of the camera's controls
  int red = 120;
  int columns = 20;  // half of the width of the surface, pixels
  int lines = 10;    // its height, below the first line
};

class WhiteBalanceControl final : public FrameControl {
 public:
  explicit WhiteBalanceControl(const WhiteBalanceSettings& settings) : settings_(settings) {}

  void start() override;
  void on_control(const VideoControl& control, Output& out) override;
  void on_frame(const pictures::PixelView& frame, Output& out) override;

 private:
  static void set(VideoControl& control, double value, Output& out);

  WhiteBalanceSettings settings_;
  VideoControl blue_{};  // id 0: the camera has no such control
  VideoControl red_{};
};

}  // namespace rack::device
