#include "components/devices/camera/exposure_control.h"

#include <algorithm>

namespace rack::device {
namespace {

using pictures::PixelLayout;
using pictures::PixelView;

// The channel of the luma, or of green, its main part. Empty: 16 bits, of which the camera uses
// some.
std::optional<int> channel_of(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::kLittle16:
    case PixelLayout::kBig16:
      return std::nullopt;
    case PixelLayout::kRgb:
    case PixelLayout::kBgr:
    case PixelLayout::kUyvy:
      return 1;
    default:
      return 0;
  }
}

}  // namespace

void ExposureControl::start() { shutter_ = gain_ = {}; }

void ExposureControl::on_control(const VideoControl& control, Output& out) {
  const bool is_controlled = settings_.part > 0;
  const auto set = [&](std::int32_t value) {
    out.send(control_bytes(std::clamp(value, control.min, control.max)), control.id);
  };
  if (control.id == video::kAutoGain)
    set(is_controlled || (settings_.shutter >= 0 && settings_.gain >= 0) ? 0 : 1);
  if (control.id == video::kShutter) {
    if (is_controlled)
      shutter_ = control;
    else if (settings_.shutter >= 0)
      set(settings_.shutter);
  }
  if (control.id == video::kGain) {
    if (is_controlled)
      gain_ = control;
    else if (settings_.gain >= 0)
      set(settings_.gain);
  }
}

void ExposureControl::on_frame(const PixelView& frame, Output& out) {
  const auto channel = channel_of(frame.layout);
  if (!channel || (shutter_.id == 0 && gain_.id == 0)) return;
  const auto shares =
      shares_of(frame, *channel, settings_.part, settings_.dark_max, settings_.bright_min);
  if (!shares) return;
  const double missing = shares->dark - shares->bright;
  const bool at_end = missing > 0 ? shutter_.value >= shutter_.max : gain_.value > gain_.min;
  const bool by_gain = shutter_.id == 0 || (gain_.id != 0 && at_end);
  if (by_gain)
    change(gain_, missing * settings_.gain_factor, out);
  else
    change(shutter_, missing * settings_.shutter_factor, out);
}

// Steps below 1 are none: small shares are normal.
void ExposureControl::change(VideoControl& control, double by, Output& out) {
  const auto value = static_cast<std::int32_t>(
      std::clamp(control.value + static_cast<double>(static_cast<int>(by)),
                 static_cast<double>(control.min), static_cast<double>(control.max)));
  if (value == control.value) return;
  control.value = value;
  out.send(control_bytes(value), control.id);
}

}  // namespace rack::device
