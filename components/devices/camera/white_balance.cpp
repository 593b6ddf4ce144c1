#include "components/devices/camera/white_balance.h"

#include <algorithm>
#include <cmath>

namespace rack::device {
namespace {

using pictures::PixelView;

constexpr double kGreyColour = 128;

}  // namespace

void WhiteBalanceControl::start() { blue_ = red_ = {}; }

void WhiteBalanceControl::on_control(const VideoControl& control, Output& out) {
  const bool is_by_camera = settings_.method == WhiteBalance::kByCamera;
  if (control.id == video::kAutoWhiteBalance)
    out.send(control_bytes(std::clamp(is_by_camera ? 1 : 0, control.min, control.max)), control.id);
  if (is_by_camera) return;
  if (control.id == video::kBlueBalance) {
    blue_ = control;
    set(blue_, settings_.blue, out);
  }
  if (control.id == video::kRedBalance) {
    red_ = control;
    set(red_, settings_.red, out);
  }
}

void WhiteBalanceControl::on_frame(const PixelView& frame, Output& out) {
  if (settings_.method != WhiteBalance::kBySurface || blue_.id == 0 || red_.id == 0) return;
  const auto columns = static_cast<std::uint32_t>(std::max(0, settings_.columns));
  const std::uint32_t middle = frame.size.width / 2;
  if (columns > middle) return;
  const auto means = colours_of(frame, {.left = middle - columns,
                                        .top = 1,
                                        .width = 2 * columns,
                                        .height = static_cast<std::uint32_t>(settings_.lines)});
  if (!means) return;
  set(blue_, blue_.value - std::round((means->u - kGreyColour) / 2), out);
  set(red_, red_.value - std::round((means->v - kGreyColour) / 2), out);
}

void WhiteBalanceControl::set(VideoControl& control, double value, Output& out) {
  const auto wanted = static_cast<std::int32_t>(
      std::clamp(value, static_cast<double>(control.min), static_cast<double>(control.max)));
  if (wanted == control.value) return;
  control.value = wanted;
  out.send(control_bytes(wanted), control.id);
}

}  // namespace rack::device
