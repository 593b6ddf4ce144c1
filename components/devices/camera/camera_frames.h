// A camera's frames as data of the camera class: colour, grey, JPEG as it came, depth.
//
// Depth comes from a depth camera (Z16: millimetres) or from two eyes whose pictures lie side by
// side. The original kept pictures from being too dark or too bright by the camera's brightness;
// so does this, where the camera has one.
#pragma once

#include "components/devices/camera/picture.h"
#include "components/devices/camera/stereo.h"
#include "components/devices/core/dialogue.h"

namespace rack::device {

struct CameraSettings {
  u16 mode = camera_mode::kRgb24;
  int quality = 75;         // of JPEG that is made here
  Duration period{};        // pictures that come faster are left out; 0: none is
  int brightness_min = 15;  // 0 to 255: darker, and the brightness is set higher
  int brightness_max = 250;
  int brightness_gain = 1000;  // a thousandth of the way for each step of 255 that is missing
  int brightness_part = 1;     // of the picture's sides that is looked at: 1 all, 2 half; 0: never
  double focal = 0;            // of one of two eyes, pixels
  double base = 0;             // between them, mm; 0: there are not two
  StereoSettings stereo{};
};

class CameraFrames final : public Dialogue {
 public:
  explicit CameraFrames(const CameraSettings& settings);

  void start(Time now, Output& out) override;
  void on_arrival(const Arrival& arrival, Output& out) override;
  void on_timeout(Time now, Output& out) override;
  [[nodiscard]] Time next_timeout() const override { return give_up_; }

  [[nodiscard]] bool is_ready() const { return has_seen_; }
  bool take(CameraData& data, Time& recorded);

  [[nodiscard]] std::uint64_t damaged() const { return damaged_; }

 private:
  bool is_due(Time when);
  tims::Result<void> make(const Arrival& frame);
  tims::Result<void> make_depth(std::span<const std::byte> frame);
  void keep_bright(Output& out);

  CameraSettings settings_;
  VideoHead head_{};
  VideoControl brightness_{};  // id 0: it cannot be set
  PictureMaker maker_;
  Stereo stereo_;
  CameraData picture_{};
  CameraData pair_{};
  bool has_picture_ = false;
  bool has_seen_ = false;  // any picture
  Time give_up_ = tims::kNever;
  Time recorded_{};
  Time due_{};
  std::uint64_t damaged_ = 0;
  int damaged_in_a_row_ = 0;
};

}  // namespace rack::device
