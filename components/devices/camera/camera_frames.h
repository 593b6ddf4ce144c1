// Converts the frames of a camera to data of the camera class: colour, grey, unchanged JPEG, depth.
//
// Depth comes from a depth camera (Z16: millimetres) or from a stereo camera with side-by-side
// pictures. As in the original, the brightness of the camera is controlled, if the camera has such
// a control.
#pragma once

#include <memory>
#include <vector>

#include "components/devices/camera/frame_control.h"
#include "components/devices/camera/frame_rectifier.h"
#include "components/devices/camera/picture.h"
#include "components/devices/camera/stereo.h"
#include "rack/devices/dialogue.h"

namespace rack::device {

struct CameraSettings {
  u16 mode = camera_mode::kRgb24;
  int quality = 75;  // quality of JPEG compressed here
  int thinning = 1;  // every n-th pixel in both directions; see thinned()
  Duration first_within = std::chrono::seconds(5);  // includes the adjustment of the exposure
  Duration period{};        // minimum period, faster pictures are skipped; 0: no limit
  int brightness_min = 15;  // 0 to 255: below, the brightness is increased
  int brightness_max = 250;
  int brightness_gain = 1000;  // 1/1000 of the control range per 1/255 of missing brightness
  int brightness_part = 1;     // evaluated part of each side: 1 all, 2 half; 0: control off
  double focal = 0;            // focal length of one stereo lens, pixels
  double base = 0;             // base line of a stereo camera, mm; 0: monocular
  StereoSettings stereo{};
  std::optional<pictures::CameraCalibration> calibration{};  // empty: not rectified
};

class CameraFrames final : public Dialogue {
 public:
  explicit CameraFrames(const CameraSettings& settings);

  // Controls of this camera, instead of its brightness control.
  void add(std::unique_ptr<FrameControl> control) { controls_.push_back(std::move(control)); }

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;

  [[nodiscard]] bool is_ready() const { return has_seen_; }
  bool take(CameraData& data, Time& recorded);

  [[nodiscard]] std::uint64_t damaged() const { return damaged_; }

 private:
  bool is_due(Time when);
  tims::Result<void> make(const Arrival& frame);
  tims::Result<void> make_depth(std::span<const std::byte> pair);
  void keep_bright(Output& out);

  CameraSettings settings_;
  VideoHead head_{};
  VideoControl brightness_{};  // id 0: the camera has no brightness control
  std::vector<std::unique_ptr<FrameControl>> controls_;
  PictureMaker maker_;
  Stereo stereo_;
  std::optional<FrameRectifier> rectifier_;  // if there is a calibration
  CameraData picture_{};
  CameraData pair_{};
  bool has_picture_ = false;
  bool has_seen_ = false;  // a picture was received
  Time recorded_{};
  Time due_{};
  std::uint64_t damaged_ = 0;
  int damaged_in_a_row_ = 0;
};

}  // namespace rack::device
